"""A flight apart: whatever ends it, the parent gives back what it held and says what happened."""

import json
import os
import pty
import signal
import subprocess
import sys
import termios
import textwrap
import time

import pytest


def start(body, **streams):
    code = (
        "from orchard_cli.commands.apart import fly_apart\n"
        "from pathlib import Path\nimport os, signal, sys, time, tty\n"
        "tell = fly_apart(True, lambda summary: {'flight': summary})\n" + textwrap.dedent(body)
    )
    return subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        **streams,
    )  # fmt: skip


@pytest.mark.parametrize("code", [0, 2, 3])
def test_a_flight_that_ends_by_itself_gives_its_own_code_and_document(code):
    flight = start(f"print('its own'); sys.exit({code})", stdin=subprocess.DEVNULL)
    said, complained = flight.communicate(timeout=30)
    assert (flight.returncode, said, complained) == (code, "its own\n", "")


@pytest.mark.parametrize(
    ("number", "word"), [("SIGALRM", "hung"), ("SIGKILL", "killed"), ("SIGSEGV", "SIGSEGV")]
)
def test_a_flight_that_is_ended_leaves_a_document_a_sentence_and_code_4(number, word):
    body = f"""
        tell(Path("a.mcap"))
        os.kill(os.getpid(), signal.{number})
        time.sleep(9)
    """
    flight = start(body, stdin=subprocess.DEVNULL)
    said, complained = flight.communicate(timeout=30)
    summary = json.loads(said)["flight"]
    assert flight.returncode == 4
    assert word in summary["ended"]
    assert not summary["as_planned"]
    assert summary["log"] == "a.mcap"
    assert complained.count("\n") == 2
    assert "take over" in complained


def test_the_terminal_is_as_it_was_when_a_flight_that_read_keys_is_killed():
    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)
    flight = start("tty.setcbreak(sys.stdin); os.kill(os.getpid(), signal.SIGKILL)", stdin=theirs)
    flight.communicate(timeout=30)
    assert termios.tcgetattr(theirs) == before
    os.close(ours)
    os.close(theirs)


HEARS = """
    heard = []
    signal.signal(signal.SIGTERM, lambda number, frame: heard.append(number))
    print("ready", flush=True)
    while not heard:
        time.sleep(0.02)
    print("home", flush=True)
"""


def test_a_signal_to_the_parent_reaches_the_flight():
    flight = start(HEARS, stdin=subprocess.DEVNULL)
    assert flight.stdout.readline() == "ready\n"
    flight.send_signal(signal.SIGTERM)
    assert flight.communicate(timeout=30)[0] == "home\n"
    assert flight.returncode == 0


def test_a_flight_whose_parent_is_killed_is_asked_to_come_home():
    flight = start(HEARS, stdin=subprocess.DEVNULL)
    assert flight.stdout.readline() == "ready\n"
    flight.kill()
    assert flight.stdout.readline() == "home\n"
    flight.communicate(timeout=30)
    assert flight.returncode == -signal.SIGKILL


def test_a_signal_before_the_flight_just_ends_it():
    flight = start("print('ready', flush=True); time.sleep(30)", stdin=subprocess.DEVNULL)
    assert flight.stdout.readline() == "ready\n"
    began = time.monotonic()
    flight.send_signal(signal.SIGTERM)
    assert flight.communicate(timeout=30) == ("", "")
    assert flight.returncode == 128 + signal.SIGTERM
    assert time.monotonic() - began < 25
