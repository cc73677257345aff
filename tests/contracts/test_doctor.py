"""What pilots and scripts may rely on of `orchard doctor`."""

from __future__ import annotations

import json
import socket
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchard_cli.commands.app import app
from orchard_cli.commands.checkups import machine, software
from orchard_cli.commands.checkups.finding import Verdict
from orchard_cli.commands.checkups.link import findings
from orchard_cli.errors import LinkError
from orchard_cli.vehicle import LinkReport
from orchard_cli.vehicle.inspection import Parameter


def test_it_prints_one_document_and_every_bad_finding_has_its_mend(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["doctor", "--json", "--folder", str(tmp_path)])
    document = json.loads(result.stdout)
    assert document["schema"] == "orchard-doctor/1"
    subjects = {f["subject"] for f in document["findings"]}
    assert {"software", "kernels", "machine", "camera"} <= subjects
    assert all(f["mend"] for f in document["findings"] if f["verdict"] == "bad")


def test_an_autopilot_that_does_not_answer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    from orchard_cli.commands.checkups import link

    def silent(url: str, flight_height: float) -> LinkReport:
        raise LinkError(f"no heartbeat on {url}")

    monkeypatch.setattr(link, "inspect_link", silent)
    (found,) = link.link("udpin://127.0.0.1:14999", 3.5)
    assert found.verdict is Verdict.BAD
    assert "no heartbeat" in found.mend


def test_stock_failsafes_are_told_with_what_they_should_be() -> None:
    report = LinkReport(
        firmware="1.17.0 (dev)",
        armed=False,
        problems=(),
        fix="fix 3d, 10 satellites",
        battery_share=0.9,
        rates={"odometry": 30.0},
        parameters=(Parameter("RTL_RETURN_ALT", 30.0, 3.5, False, "a return climbs"),),
    )
    bad = [f for f in findings(report) if f.verdict is Verdict.BAD]
    assert [f.item for f in bad] == ["RTL_RETURN_ALT"]
    assert bad[0].found == "30"
    assert "should be 3.5" in bad[0].mend


@pytest.mark.parametrize(
    ("have", "rule", "kept"),
    [
        ("2.4.6", ">=2.0", True),
        ("1.26", ">=2.0", False),
        ("4.1.0", ">=4.1,<5", True),
        ("5.0", ">=4.1,<5", False),
        ("2.0", ">=2", True),
        ("0.65.0rc1", ">=0.60", True),
        ("1", "", True),
    ],
)
def test_versions_are_compared_by_their_numbers(have: str, rule: str, kept: bool) -> None:
    assert software.satisfies(have, rule) is kept


def test_a_port_that_is_taken_is_a_note() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as taken:
        taken.bind(("127.0.0.1", 0))
        number = taken.getsockname()[1]
        assert machine.port(number, "test").verdict is Verdict.NOTE
    assert machine.port(number, "test").verdict is Verdict.OK


def test_a_folder_that_is_none_is_the_users_fault(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["doctor", "--folder", str(tmp_path / "none")])
    assert result.exit_code == 1 or isinstance(result.exception, Exception)
    assert "--folder" in str(result.exception)
