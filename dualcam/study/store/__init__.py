"""The files of a study, which goes on where it was interrupted, and the table of its results."""
