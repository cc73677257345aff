"""The kernel ends a hung process; a living one goes on."""

import signal
import subprocess
import sys
import textwrap


def run(body: str) -> subprocess.CompletedProcess:
    code = "from orchard_cli.vehicle.deadman import Deadman\nimport time\n" + textwrap.dedent(body)
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, timeout=30, check=False
    )


def test_a_process_that_holds_the_gil_is_ended_by_the_kernel():
    done = run(
        """
        deadman = Deadman(0.3)
        deadman.feed()
        sum(range(10**12))
        """
    )
    assert done.returncode == -signal.SIGALRM


def test_a_process_that_feeds_lives_and_a_disarmed_one_may_rest():
    done = run(
        """
        deadman = Deadman(0.3)
        for _ in range(10):
            deadman.feed()
            time.sleep(0.1)
        deadman.disarm()
        time.sleep(0.6)
        print("alive")
        """
    )
    assert done.returncode == 0
    assert done.stdout.strip() == b"alive"
