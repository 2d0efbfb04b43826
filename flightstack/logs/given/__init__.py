"""What the commands are given: arguments, logs, folders of logs."""
