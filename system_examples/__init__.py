"""One question each, to be read from top to bottom and copied for an own system."""
