"""What is wrong with a study as a whole."""

from dualcam.errors import FmuError


class StudyError(FmuError):
    """This study cannot be made, or not be continued; the message says what to do."""
