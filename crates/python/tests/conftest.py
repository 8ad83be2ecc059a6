import lifelike
import pytest


@pytest.fixture(scope="session")
def robot():
    return lifelike.Robot("lima")


@pytest.fixture(scope="session")
def controller():
    return lifelike.Controller("lima")


@pytest.fixture(scope="session")
def clips(robot):
    return lifelike.load_clips("builtin", robot)


@pytest.fixture(scope="session")
def walk(clips):
    return next(clip for clip in clips if clip.name == "walk")
