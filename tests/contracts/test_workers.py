"""Every worker: one job at a time, each result once, a throwing job is a result."""

import time

import pytest

from orchard_cli.flight.worker import InlineWorker, ThreadWorker


def half(x):
    if x == 0:
        raise ValueError("zero")
    return x / 2


@pytest.fixture(params=[ThreadWorker, InlineWorker])
def worker(request):
    made = request.param(half)
    yield made
    made.close()


def wait(worker):
    for k in range(500):
        result = worker.take(1.0 + k)
        if result is not None:
            return result
        time.sleep(0.01)
    raise AssertionError("no result")


def test_a_result_is_handed_out_once_and_then_the_worker_is_idle(worker):
    assert worker.idle()
    worker.give(3, 0.0)
    assert not worker.idle()
    assert wait(worker) == 1.5
    assert worker.take(1e6) is None
    assert worker.idle()


def test_a_throwing_job_is_told_and_the_next_one_runs(worker):
    worker.give(0, 0.0)
    assert isinstance(wait(worker), ValueError)
    worker.give(4, 0.0)
    assert wait(worker) == 2.0


def test_inline_results_come_after_their_latency():
    worker = InlineWorker(half, latency=0.04)
    worker.give(2, 10.0)
    assert worker.take(10.03) is None
    assert worker.take(10.05) == 1.0
