"""What tests expect of errors."""

import pytest


def refused_by(error: type[Exception], *mentions: str) -> pytest.RaisesExc:
    """Expects this error, whose text has each of these regular expressions."""
    return pytest.raises(error, match="".join(f"(?=(?s:.*){mention})" for mention in mentions))
