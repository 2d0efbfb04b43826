"""What the rows tell: estimates with intervals, tables, and the paper's figures beside them."""
