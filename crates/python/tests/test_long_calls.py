"""Long calls release the GIL and stop at Ctrl-C."""

import signal
import subprocess
import sys
import threading
import time

import lifelike
import pytest


def test_other_threads_run_during_an_evaluation(controller, clips):
    count, stop = [0], threading.Event()

    def work():
        while not stop.is_set():
            count[0] += 1

    thread = threading.Thread(target=work)
    thread.start()
    before = count[0]
    lifelike.evaluate(controller, clips, starts=5)
    after = count[0]
    stop.set()
    thread.join()
    # A call that holds the GIL lets the other thread make no round at all.
    assert after - before > 1000


EVALUATE = """
controller = lifelike.Controller("lima")
clips = lifelike.load_clips("builtin", controller.robot)
def call(): lifelike.evaluate(controller, clips, starts=10000)
def after(): assert lifelike.evaluate(controller, clips[:1], starts=1)["overall"]["episodes"] == 1
"""

TRAIN = """
def call(): lifelike.train_tracker(folder, changes=["ppo.environments=64", "ppo.minibatch=384"])
def after():
    changes = ["budget.steps=1"]
    told = []
    policy = lifelike.train_tracker(folder, resume=True, changes=["budget.steps=1"], progress=told.append)
    assert policy.is_file(), policy
"""

# A test that was started in the background inherits a Ctrl-C that is ignored.
SCRIPT = """
import lifelike, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
folder = sys.argv[1]
{}
print("started", flush=True)
try:
    call()
except KeyboardInterrupt:
    print("interrupted", flush=True)
after()
print("went on", flush=True)
"""


@pytest.mark.parametrize("script", [EVALUATE, TRAIN], ids=["evaluate", "train"])
def test_ctrl_c_interrupts_and_the_process_goes_on(script, tmp_path):
    line = [sys.executable, "-c", SCRIPT.format(script), str(tmp_path / "run")]
    process = subprocess.Popen(line, stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "started\n"
    time.sleep(4)
    assert process.poll() is None, "the call is long"
    process.send_signal(signal.SIGINT)
    began = time.monotonic()
    assert process.stdout.readline() == "interrupted\n"
    assert time.monotonic() - began < 10
    assert process.stdout.readline() == "went on\n"
    assert process.wait() == 0


def test_training_reports_and_its_policy_is_a_controller(tmp_path):
    changes = ["budget.steps=8000", "ppo.environments=64", "ppo.minibatch=384"]
    told = []
    policy = lifelike.train_tracker(tmp_path / "run", changes=changes, progress=told.append)
    assert [now["iteration"] for now in told] == list(range(1, len(told) + 1)) and told[-1]["steps"] >= 8000
    controller = lifelike.Controller(policy)
    assert controller.robot.name == "lima"
    with pytest.raises(lifelike.Error, match="run"):
        lifelike.train_tracker(tmp_path / "run", changes=changes)


def test_an_exception_of_the_progress_ends_the_training(tmp_path):
    def fail(now):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        lifelike.train_tracker(tmp_path / "run", changes=["ppo.environments=64", "ppo.minibatch=384"], progress=fail)


def test_ctrl_c_ends_the_command(tmp_path):
    line = [sys.executable, "-m", "lifelike", "eval", "--policy", "lima", "--motions", "builtin", "--starts", "10000"]
    process = subprocess.Popen([*line, "-o", str(tmp_path / "report")], stderr=subprocess.DEVNULL)
    time.sleep(4)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    assert process.wait(10) == -signal.SIGINT
