"""Write a log in the formats of other tools: CSV, Parquet, MCAP."""
