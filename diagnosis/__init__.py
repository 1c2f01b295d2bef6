"""What is missing, where and why: a diagnosis of the gap between a valve and its model."""
