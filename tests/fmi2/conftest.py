"""Fixtures of the FMI 2.0 tests."""

import pytest
from driver import models


@pytest.fixture(scope="session", params=models.values(), ids=repr)
def model(request):
    """Every test here is about both FMUs, unless it says which."""
    return request.param
