"""Laws of the metrics: figures known beforehand are found, and what is not known is not 0."""

from __future__ import annotations

from dataclasses import replace

import made_flights as made
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.analysis import Clearances, Unknown, measure, signals
from orchard_cli.analysis.coverage import compare
from orchard_cli.analysis.lines import Line
from orchard_cli.analysis.verdicts import verdicts
from orchard_cli.flightlog import McapRecorder, read
from orchard_cli.model.arrays import frozen
from orchard_cli.model.flown import Track
from orchard_cli.model.records import OccupiedCells, PlannerRecord, SprayRecord, TruthRecord
from orchard_cli.model.vehicle import Setpoint, VehicleState

NO_WORLD = Unknown("no world")


@pytest.fixture(scope="module")
def plan():
    return made.mission(2)


@pytest.fixture(scope="module")
def fly(plan, tmp_path_factory):
    """Log a made-up flight and read it back."""
    folder = tmp_path_factory.mktemp("flights")

    def flown(detour=made.no_detour, change=lambda records: records, mission=plan, **options):
        recorder = McapRecorder(folder / "flight.mcap", patient=True, overwrite=True)
        for record in change(list(made.flight(mission, detour, **options))):
            recorder.write(record)
        recorder.close()
        return read(folder / "flight.mcap")

    return flown


def track(times, positions, velocities=None, yaws=None, rates=None) -> Track:
    n = len(times)
    yaws = np.zeros(n) if yaws is None else np.asarray(yaws)
    zero = np.zeros(n)
    return Track(
        times=times,
        positions_site=positions,
        velocities_site=np.zeros((n, 3)) if velocities is None else velocities,
        site_from_body=np.column_stack([np.cos(yaws / 2), zero, zero, np.sin(yaws / 2)]),
        angular_velocities_body=np.full((n, 3), np.nan) if rates is None else rates,
    )


def test_a_flight_on_the_line_has_the_routes_length_and_no_deviation(plan, fly):
    figures = measure(fly(), plan, NO_WORLD).figures
    assert figures["distance_m"] == pytest.approx(plan.route_length, abs=0.5)
    assert figures["duration_s"] == pytest.approx(plan.route_length / made.SPEED, abs=0.3)
    assert figures["deviation_max_m"] == pytest.approx(0.0, abs=1e-9)
    assert figures["height_error_max_m"] == pytest.approx(0.0, abs=1e-9)
    assert figures["avoidances"] == 0
    assert figures["coverage_percent"] > 99.9
    assert figures["missed_strip_m"] == 0.0


@settings(max_examples=6, deadline=None, derandomize=True)
@given(peak=st.floats(0.5, 2.5), centre=st.floats(6.0, 14.0), drop=st.floats(0.0, 0.6))
def test_one_detour_is_one_avoidance_with_its_peak_and_drop(plan, fly, peak, centre, drop):
    found = measure(fly(made.Bump(centre, 6.0, peak, drop)), plan, NO_WORLD)
    (avoidance,) = found.avoidances
    assert found.figures["avoidance_peak_mean_m"] == pytest.approx(peak, abs=0.01)
    assert found.figures["deviation_max_m"] == pytest.approx(peak, abs=0.01)
    lost_before = drop * 0.1 / peak  # the detour counts from 0.1 m on
    drops = found.figures["altitude_drop_max_m"]
    assert drop - lost_before - 0.01 <= drops <= drop + 0.01
    assert avoidance.peak_site[0] == pytest.approx(centre, abs=0.1)
    assert 2.0 < avoidance.end - avoidance.start < 6.0


def test_two_detours_are_two_avoidances_and_their_peaks_are_averaged(plan, fly):
    def both(positions):
        return made.Bump(15.0, 4.0, 1.0)(made.Bump(5.0, 4.0, 2.0)(positions))

    found = measure(fly(both), plan, NO_WORLD)
    assert [round(one.peak_m, 1) for one in found.avoidances] == [2.0, 1.0]
    assert found.figures["avoidance_peak_mean_m"] == pytest.approx(1.5, abs=0.01)


def test_without_commands_an_avoidance_is_seen_in_the_flown_path(plan, fly):
    def silent(records):
        return [r for r in records if not isinstance(r, Setpoint)]

    found = measure(fly(made.Bump(peak=1.5), silent), plan, NO_WORLD)
    assert len(found.avoidances) == 1
    assert isinstance(found.figures["acceleration_planned_max_m_s2"], Unknown)


def test_pump_off_over_a_stretch_is_missed_coverage(plan, fly):
    """Off for 5 m of the first row's 20 m: the strip is 46 m in all."""

    def off(records):
        pump = [SprayRecord(105.0, False, None, "off"), SprayRecord(110.0, True, 0, "on")]
        return sorted([*records[1:], *pump], key=lambda r: r.time)

    figures = measure(fly(change=lambda r: [r[0], *off(r)]), plan, NO_WORLD).figures
    assert figures["missed_strip_m"] == pytest.approx(5.0, abs=0.1)
    assert figures["coverage_percent"] == pytest.approx(100 * (1 - 5 / 46), abs=0.5)


def test_missing_sources_are_unknown_with_a_reason_never_zero(plan, fly):
    bare = replace(
        fly(), spray=(), planner=(), battery_shares=np.full(0, np.nan), battery_times=np.empty(0)
    )
    figures = measure(bare, plan, NO_WORLD).figures
    for name in (
        "clearance_min_m",
        "clearance_trees_min_m",
        "coverage_percent",
        "replans",
        "battery_used_percent",
        "liquid_used_l",
        "avoidance_peak_mean_m",
    ):
        assert isinstance(figures[name], Unknown), name
        assert figures[name].why


def test_names_are_the_same_whether_or_not_the_route_was_flown(plan, fly):
    flown = fly()
    empty = replace(flown, odometry=flown.odometry.between(0.0, 1.0))
    whole, none = measure(flown, plan, NO_WORLD), measure(empty, plan, NO_WORLD)
    assert list(whole.figures) == list(none.figures)
    assert isinstance(none.figures["distance_m"], Unknown)
    assert (none.start, none.end, none.avoidances) == (None, None, ())


def test_a_flight_that_gave_up_has_no_distance_but_its_deviations(plan, fly):
    flown = fly(made.Bump(peak=1.0))
    cut = replace(flown, odometry=flown.odometry.between(0.0, 120.0))
    found = measure(cut, plan, NO_WORLD)
    assert isinstance(found.figures["distance_m"], Unknown)
    assert found.figures["deviation_max_m"] == pytest.approx(1.0, abs=0.01)
    assert any("last waypoint" in note for note in found.notes)


def test_clearance_is_the_smallest_to_an_obstacle_over_the_whole_flight(plan, fly):
    flown = fly(made.Bump(peak=1.5))
    pole = np.array([10.0, 0.0])
    times = flown.truth.times
    away = np.linalg.norm(flown.truth.positions_site[:, :2] - pole, axis=1) - 0.15
    found = measure(flown, plan, Clearances(times, away, np.full(len(times), np.inf)))
    assert found.figures["clearance_min_m"] == away.min()
    assert found.avoidances[0].clearance_min_m == away.min() == pytest.approx(1.35, abs=0.02)
    assert isinstance(found.figures["clearance_trees_min_m"], Unknown)


def test_without_a_world_the_map_gives_the_clearance(plan, fly):
    flown = replace(
        fly(), truth=None, maps=(OccupiedCells(100.0, np.array([[10.0, 2.0, 3.5]]), 0.1),)
    )
    figures = measure(flown, plan, NO_WORLD).figures
    assert figures["clearance_min_m"] == pytest.approx(1.95, abs=0.01)


def test_latency_and_decisions_are_counted(plan, fly):
    def cycle(decision, ms):
        return PlannerRecord(101.0, 100.9, decision, "", None, {"search": ms})

    flown = replace(fly(), planner=tuple(map(cycle, ["keep", "avoid", "avoid", "stop"], range(4))))
    figures = measure(flown, plan, NO_WORLD).figures
    assert (figures["replans"], figures["replan_failures"]) == (2, 1)
    assert figures["latency_search_median_ms"] == 1.5
    assert figures["latency_search_max_ms"] == 3.0


def test_figures_do_not_depend_on_the_logging_rate(plan, fly):
    slow, fast = (
        measure(fly(made.Bump(drop=0.2), rate=rate), plan, NO_WORLD).figures for rate in (15, 60)
    )
    for name, tolerance in (
        ("distance_m", 0.15),  # the made-up corners are sharp
        ("deviation_mean_m", 0.01),
        ("deviation_p95_m", 0.05),
        ("height_error_rms_m", 0.01),
    ):
        assert slow[name] == pytest.approx(fast[name], abs=tolerance), name


def test_verdicts_tell_rule_limit_and_figure(plan, fly):
    flown = fly(made.Bump(peak=1.5))
    times = flown.truth.times
    near = Clearances(times, np.full(len(times), 0.5), np.full(len(times), 1.0))
    by_name = {v.metric: v for v in verdicts(measure(flown, plan, near), plan)}
    assert by_name["clearance_min_m"].kept is False
    assert by_name["clearance_min_m"].limit == plan.limits.clearance
    assert by_name["clearance_trees_min_m"].kept is True
    unknown = {v.metric: v for v in verdicts(measure(flown, plan, NO_WORLD), plan)}
    assert unknown["clearance_min_m"].kept is None


def crash(records, at=110.0):
    """The vehicle touches a pole and falls; the flight goes on sending."""
    for one in records:
        time = getattr(one, "time", 0.0)
        if isinstance(one, VehicleState | TruthRecord) and time > at:
            fallen = one.position_site * [1.0, 1.0, 0.0]
            one = replace(one, position_site=fallen, velocity_site=np.array([0.0, 0.0, -8.0]))  # noqa: PLW2901
        yield replace(one, contact="pole 2") if isinstance(one, TruthRecord) and time >= at else one


def test_a_contact_is_counted_named_and_condemned_and_the_fall_is_no_flight(plan, fly):
    flown = fly(change=crash)
    times = flown.truth.times
    through = Clearances(
        times, np.where(times > 110.0, -0.1, 0.4), np.where(times > 110.0, 0.1, 1.5)
    )
    found = measure(flown, plan, through)
    assert found.figures["contacts"] == 1
    assert "touched pole 2 at t = 110.0 s" in found.notes
    assert found.figures["clearance_min_m"] == 0.4
    assert found.figures["clearance_trees_min_m"] == 1.5
    assert found.figures["height_error_max_m"] < 0.01
    assert found.figures["speed_max_m_s"] < 1.1
    assert found.figures["acceleration_max_m_s2"] < 0.5
    assert isinstance(found.figures["distance_m"], Unknown)
    (verdict,) = (v for v in verdicts(found, plan) if v.metric == "contacts")
    assert verdict.kept is False
    assert verdict.found_text == "pole 2 at t = 110.0 s"


def test_a_flight_without_contact_is_told_from_one_of_which_it_is_not_known(plan, fly):
    for flown, figure, kept in ((fly(), 0, True), (replace(fly(), contacts=None), None, None)):
        found = measure(flown, plan, NO_WORLD)
        (verdict,) = (v for v in verdicts(found, plan) if v.metric == "contacts")
        assert verdict.kept is kept
        assert not any("touched" in note for note in found.notes)
        if figure is None:
            assert isinstance(found.figures["contacts"], Unknown)
        else:
            assert found.figures["contacts"] == figure


@pytest.mark.parametrize(("share", "kept"), [(1.0 + 1e-9, True), (1.009, True), (1.011, False)])
def test_a_command_may_exceed_its_limit_by_the_time_laws_tolerance(plan, fly, share, kept):
    def pushed(records):
        size = np.array([share * plan.limits.acceleration, 0.0, 0.0])
        return [
            replace(one, acceleration_site=size) if isinstance(one, Setpoint) else one
            for one in records
        ]

    by_name = {v.metric: v for v in verdicts(measure(fly(change=pushed), plan, NO_WORLD), plan)}
    verdict = by_name["acceleration_planned_max_m_s2"]
    assert verdict.kept is kept
    assert "1%" in verdict.rule


# -- signals


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    turns=st.floats(-3.0, 3.0),
    start=st.floats(-np.pi, np.pi),
    seconds=st.floats(5.0, 30.0),
)
def test_yaw_rate_never_steps_at_the_wrap(turns, start, seconds):
    times = np.linspace(0.0, seconds, int(seconds * 30))
    rate = turns * 2 * np.pi / seconds
    _, found = signals.yaw_rates(track(times, np.zeros((len(times), 3)), yaws=start + rate * times))
    np.testing.assert_allclose(found, rate, atol=0.02 * abs(rate) + 1e-6)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    roll=st.floats(-0.5, 0.5),
    pitch=st.floats(-0.5, 0.5),
    yaw=st.floats(-3, 3),
    rate=st.floats(-2, 2),
)
def test_yaw_rate_of_a_tilted_vehicle_is_that_of_its_heading(roll, pitch, yaw, rate):
    """A vehicle that turns about the site's upright axis while tilted turns at that rate."""
    from scipy.spatial.transform import Rotation

    attitude = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    body = attitude.inv().apply([0.0, 0.0, rate])
    one = Track(
        times=[0.0, 1.0],
        positions_site=np.zeros((2, 3)),
        velocities_site=np.zeros((2, 3)),
        site_from_body=np.tile(attitude.as_quat(scalar_first=True), (2, 1)),
        angular_velocities_body=np.tile(body, (2, 1)),
    )
    np.testing.assert_allclose(signals.yaw_rates(one)[1], rate, atol=1e-9)


def test_noise_is_no_acceleration_and_no_distance():
    rng = np.random.default_rng(3)
    times = np.arange(0.0, 120.0, 0.02)
    positions = np.column_stack([times, 0 * times, 0 * times + 3.5])
    noisy = track(
        times,
        positions + rng.normal(0.0, 0.01, positions.shape),
        np.tile([1.0, 0.0, 0.0], (len(times), 1)) + rng.normal(0.0, 0.03, positions.shape),
    )
    assert signals.path_length(noisy) == pytest.approx(120.0, rel=0.005)
    assert signals.accelerations(noisy)[1].max() < 0.15


@pytest.mark.parametrize("period", [2.0, 4.0, 8.0])
def test_a_real_change_of_speed_is_acceleration(period):
    times = np.arange(0.0, 40.0, 0.02)
    speed = 0.3 * np.sin(2 * np.pi * times / period)
    velocities = np.column_stack([speed, 0 * speed, 0 * speed])
    peak = 0.3 * 2 * np.pi / period
    found = signals.accelerations(track(times, np.zeros((len(times), 3)), velocities))[1]
    assert found[200:-200].max() == pytest.approx(peak, rel=0.08)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    gaps=st.lists(st.floats(0.01, 2.0), min_size=1, max_size=30),
    value=st.floats(-5.0, 5.0),
)
def test_time_statistics_of_a_constant_are_the_constant(gaps, value):
    times = np.concatenate([[0.0], np.cumsum(gaps)])
    values = np.full(len(times), value)
    assert signals.shares(times).sum() == pytest.approx(1.0)
    assert signals.mean(times, values) == pytest.approx(value)
    assert signals.rms(times, values) == pytest.approx(abs(value))
    assert signals.percentile_95(times, values) == value


def test_a_burst_of_samples_does_not_outweigh_time():
    """Ten samples within 0.1 s count as 0.1 s, not as ten."""
    times = np.concatenate([[0.0, 1.0], np.linspace(1.01, 1.1, 10), [2.1, 3.1]])
    values = np.concatenate([[0.0, 0.0], np.ones(10), [0.0, 0.0]])
    assert signals.mean(times, values) < 0.25


# -- lines and strips


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    points=st.lists(st.tuples(st.floats(-30, 30), st.floats(-30, 30)), min_size=1, max_size=20),
)
def test_distance_to_a_line_is_the_smallest_over_its_segments(points):
    corners = made.corners(3)
    places = np.array([[x, y, 0.0] for x, y in points])
    found = Line(corners).offset(places)
    dense = made.along(corners, np.linspace(0.0, made.length(corners), 4000))
    brute = np.linalg.norm(places[:, None, :2] - dense[None, :, :2], axis=2).min(axis=1)
    np.testing.assert_allclose(found.distance, brute, atol=0.02)
    np.testing.assert_allclose(found.height, made.HEIGHT)


strip = st.tuples(st.floats(0, 50), st.floats(0, 50)).filter(lambda s: abs(s[0] - s[1]) > 0.5)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(flown=st.lists(strip, max_size=5), swath=st.floats(0.5, 5.0))
def test_coverage_of_one_row_is_the_share_of_its_length(flown, swath):
    row = np.array([[0.0, 0.0], [50.0, 0.0]])
    lines = [np.array([[a, 0.0], [b, 0.0]]) for a, b in flown]
    found = compare([row], lines, swath)
    at = np.linspace(0.0, 50.0, 5001)
    covered = np.zeros(len(at), bool)
    for a, b in flown:
        covered |= (at >= min(a, b)) & (at <= max(a, b))
    assert found.percent == pytest.approx(100 * covered.mean(), abs=0.3)
    total = sum(abs(a - b) for a, b in flown)
    treated = covered.mean() * 50.0
    if treated > 0:
        assert found.overlap_percent == pytest.approx(100 * (total / treated - 1), abs=3.0)


def test_flying_a_field_without_obstacles_covers_it_once():
    """Rows a swath apart: eq. 30's field, without the half swath beyond its edges."""
    rows = [np.array([[0.0, y], [40.0, y]]) for y in (0.0, 4.0, 8.0, 12.0)]
    found = compare(rows, rows, 4.0)
    assert found.percent == pytest.approx(100.0)
    assert found.overlap_percent == pytest.approx(0.0, abs=1e-9)
    assert found.missed_strip_m == 0.0


def test_what_is_sprayed_beside_the_rows_is_no_coverage():
    row = np.array([[0.0, 0.0], [10.0, 0.0]])
    assert compare([row], [row + np.array([0.0, 100.0])], 2.0).percent == pytest.approx(0.0)


def test_times_of_a_track_must_increase():
    with pytest.raises(ValueError, match="not increasing"):
        track(np.array([0.0, 0.0]), np.zeros((2, 3)))
    assert not frozen([1.0], (None,), "x").flags.writeable


@pytest.mark.parametrize("steady", [False, True])
@pytest.mark.parametrize("n", [10, 40, 1500])
def test_the_low_pass_is_scipys(n, steady):
    from scipy.signal import butter, sosfiltfilt

    times = np.arange(n) * 0.05
    values = np.cumsum(np.random.default_rng(n).normal(size=(n, 2)), axis=0) + 50.0
    _, ours = signals.smooth(times, values, steady)
    sections = butter(2, signals.CUTOFF, fs=20.0, output="sos")
    kind = "even" if steady else "odd"
    theirs = sosfiltfilt(sections, values, axis=0, padtype=kind, padlen=min(n - 1, 60))
    np.testing.assert_allclose(ours, theirs, atol=1e-8)
