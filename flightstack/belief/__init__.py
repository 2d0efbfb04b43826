"""What is believed of the gates, over time: pure functions over frozen records, numpy, no clock."""
