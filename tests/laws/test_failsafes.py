"""The autopilot's own failsafes, judged before arming."""

from orchard_cli.vehicle.failsafes import judge, rules

STOCK = {"COM_OF_LOSS_T": 1.0, "COM_OBL_RC_ACT": 0.0, "RTL_RETURN_ALT": 30.0, "NAV_DLL_ACT": 0.0}


def test_stock_px4_is_not_safe_under_trees_because_it_climbs_to_30_m():
    found = {finding.name for finding in judge(STOCK, 3.5)}
    assert found == {"COM_OBL_RC_ACT", "RTL_RETURN_ALT"}


def test_the_wanted_values_are_themselves_safe():
    for rule in rules(3.5):
        assert rule.safe(rule.wanted)


def test_a_missing_parameter_is_a_finding_that_says_so():
    found = judge({**STOCK, "COM_OF_LOSS_T": None}, 3.5)
    assert any("COM_OF_LOSS_T is missing" in str(finding) for finding in found)
