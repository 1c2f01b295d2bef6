"""What does a controller do with set point and reading? Compiled laws, one file each."""
