"""DJI's waypoint files (WPML 1.0.2, .kmz): for DJI Pilot 2, FlightHub 2 and the Mobile SDK.

Format: DJI developer documentation, "Waypoint File Format Standard". Heights are relative to the
start point. WPML has no sprayer: the pump's begin and end are the actions startRecord and
stopRecord, which a payload with its own pump can follow. It carries no fence.
"""

from __future__ import annotations

import io
import zipfile
import zlib

import numpy as np
from lxml import etree
from lxml.builder import ElementMaker

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.site import HeightReference

from .course import Course, Loaded
from .xml import KML, parsed, rendered, text

WPML = "http://www.dji.com/wpmz/1.0.2"
_NAMES = {"k": KML, "w": WPML}
_K = ElementMaker(namespace=KML, nsmap={None: KML, "wpml": WPML})
_W = ElementMaker(namespace=WPML, nsmap={"wpml": WPML})
_TEMPLATE, _WAYLINES = "wpmz/template.kml", "wpmz/waylines.wpml"
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the same mission gives the same file
_LARGEST = 50_000_000  # bytes unpacked
_SECURITY = (1.2, 1500.0)  # m, what DJI takes as take-off security height
_ON, _OFF = "startRecord", "stopRecord"
_M350, _ANY_CAMERA = ("89", "0"), "65534"  # droneEnumValue and sub type; "another payload"


def write(course: Course) -> bytes:
    """The bytes of a .kmz file."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, root in ((_TEMPLATE, _template(course)), (_WAYLINES, _waylines(course))):
            archive.writestr(zipfile.ZipInfo(name, _EPOCH), rendered(root), zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def _template(course: Course) -> etree._Element:
    folder = _K.Folder(
        _W.templateType("waypoint"),
        _W.templateId("0"),
        _W.waylineCoordinateSysParam(
            _W.coordinateMode("WGS84"), _W.heightMode("relativeToStartPoint")
        ),
        _W.autoFlightSpeed(_metres(course.speed)),
        _W.globalHeight(_metres(float(course.heights[0]))),
        _W.caliFlightEnable("0"),
        _W.gimbalPitchMode("manual"),
        _heading(),
        _W.globalWaypointTurnMode("toPointAndStopWithDiscontinuityCurvature"),
        _W.globalUseStraightLine("1"),
    )
    for k, height in enumerate(course.heights):
        mark = _placemark(course, k)
        mark.append(_W.height(_metres(float(height))))
        if course.reference is HeightReference.ELLIPSOID:  # else it is not known
            mark.append(_W.ellipsoidHeight(_metres(float(course.places_wgs84[k, 2]))))
        for name in ("GlobalHeight", "GlobalSpeed", "GlobalHeadingParam", "GlobalTurnParam"):
            mark.append(_W(f"use{name}", "0" if name == "GlobalHeight" else "1"))
        mark.append(_W.useStraightLine("1"))
        _act(mark, course, k)
        folder.append(mark)
    return _K.kml(_K.Document(_W.author("orchard"), _config(course), folder))


def _waylines(course: Course) -> etree._Element:
    folder = _K.Folder(
        _W.templateId("0"),
        _W.executeHeightMode("relativeToStartPoint"),
        _W.waylineId("0"),
        _W.autoFlightSpeed(_metres(course.speed)),
    )
    for k, height in enumerate(course.heights):
        mark = _placemark(course, k)
        mark.append(_W.executeHeight(_metres(float(height))))
        mark.append(_W.waypointSpeed(_metres(course.speed)))
        mark.append(_heading())
        mark.append(
            _W.waypointTurnParam(
                _W.waypointTurnMode("toPointAndStopWithDiscontinuityCurvature"),
                _W.waypointTurnDampingDist("0"),
            )
        )
        mark.append(_W.useStraightLine("1"))
        _act(mark, course, k)
        folder.append(mark)
    return _K.kml(_K.Document(_config(course), folder))


def _config(course: Course) -> etree._Element:
    security = float(np.clip(course.heights[0], *_SECURITY))
    return _W.missionConfig(
        _W.flyToWaylineMode("safely"),
        _W.finishAction("autoLand"),
        _W.exitOnRCLost("executeLostAction"),
        _W.executeRCLostAction("goBack"),
        _W.takeOffSecurityHeight(_metres(security)),
        _W.globalTransitionalSpeed(_metres(course.speed)),
        _W.droneInfo(_W.droneEnumValue(_M350[0]), _W.droneSubEnumValue(_M350[1])),
        _W.payloadInfo(
            _W.payloadEnumValue(_ANY_CAMERA),
            _W.payloadSubEnumValue("0"),
            _W.payloadPositionIndex("0"),
        ),
    )


def _placemark(course: Course, k: int) -> etree._Element:
    latitude, longitude = course.places_wgs84[k, :2]
    point = _K.Point(_K.coordinates(f"{longitude:.9f},{latitude:.9f}"))
    return _K.Placemark(point, _W.index(str(k)))


def _heading() -> etree._Element:
    return _W.waypointHeadingParam(
        _W.waypointHeadingMode("followWayline"),
        _W.waypointHeadingAngle("0"),
        _W.waypointPoiPoint("0.000000,0.000000,0.000000"),
        _W.waypointHeadingPathMode("followBadArc"),
    )


def _act(mark: etree._Element, course: Course, k: int) -> None:
    """At a place where the pump changes: the action that says so. At the first it is turned off."""
    before = k > 0 and course.ways[k - 1].sprays
    after = k < len(course.ways) and course.ways[k].sprays
    if before == after and k > 0:
        return
    mark.append(
        _W.actionGroup(
            _W.actionGroupId(str(k)),
            _W.actionGroupStartIndex(str(k)),
            _W.actionGroupEndIndex(str(k)),
            _W.actionGroupMode("sequence"),
            _W.actionTrigger(_W.actionTriggerType("reachPoint")),
            _W.action(
                _W.actionId("0"),
                _W.actionActuatorFunc(_ON if after else _OFF),
                _W.actionActuatorFuncParam(
                    _W.payloadPositionIndex("0"), _W.useGlobalPayloadLensIndex("1")
                ),
            ),
        )
    )


def _metres(value: float) -> str:
    return f"{value:.4f}"


def read(data: bytes) -> Loaded:
    """Read the waylines of a .kmz file. Raises InputError for anything else."""
    root = parsed(_unpacked(data, _WAYLINES), _WAYLINES)
    marks = root.findall(".//k:Placemark", _NAMES)
    modes = root.findall(".//w:executeHeightMode", _NAMES)
    if not marks or [mode.text for mode in modes] != ["relativeToStartPoint"]:
        raise InputError(Fault(_WAYLINES, "holds no wayline in relative heights"))
    places, changes, on = [], [], False
    try:
        marks.sort(key=lambda mark: int(text(mark, "w:index", _NAMES)))
        for mark in marks:
            longitude, latitude = text(mark, "k:Point/k:coordinates", _NAMES).split(",")[:2]
            height = text(mark, "w:executeHeight", _NAMES)
            places.append([float(latitude), float(longitude), float(height)])
            for action in mark.findall(".//w:actionActuatorFunc", _NAMES):
                on = action.text == _ON
            changes.append(on)
    except ValueError as error:
        raise InputError(Fault(_WAYLINES, str(error))) from error
    table = np.array(places)
    return Loaded(table[:, :2], table[:, 2], tuple(changes[:-1]))


def _unpacked(data: bytes, name: str) -> bytes:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if archive.getinfo(name).file_size > _LARGEST:
                raise InputError(Fault(name, "is too large"))
            return archive.read(name)
    except (zipfile.BadZipFile, KeyError, zlib.error) as error:
        raise InputError(Fault("kmz", f"is no waypoint file: {error}")) from error
