"""What all other rooms of the package share."""
