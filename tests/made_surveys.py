"""Surveys written in other forms: by plain text and, for KML, by fastkml, which is not ours."""

from __future__ import annotations

import json

import numpy as np

from orchard_cli.geometry.geodesy import wgs84_from_site


def trees_of(orchard):
    """(row, place on earth (3,), site place (2,), ground, height) of each tree, row by row."""
    for k, row in enumerate(orchard.rows, 1):
        flat = np.column_stack([row.trunks_site, np.zeros(len(row.trunks_site))])
        earth = wgs84_from_site(orchard.origin, flat)
        for tree in zip(earth, row.trunks_site, row.ground, row.heights, strict=True):
            yield (k, *tree)


def degrees(orchard, site):
    """[longitude, latitude] to a tenth of a millimetre, of (2,) m."""
    latitude, longitude, _ = wgs84_from_site(orchard.origin, np.array([[*site, 0.0]]))[0]
    return [round(float(longitude), 9), round(float(latitude), 9)]


def geojson_trees(orchard):
    """The trees as a list of GeoJSON features."""
    return [
        point(degrees(orchard, site), height_m=float(height))
        for _, _, site, _, height in trees_of(orchard)
    ]


def point(position, **properties):
    return feature({"type": "Point", "coordinates": position}, **properties)


def feature(geometry, **properties):
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def collection(features, **members):
    return json.dumps({"type": "FeatureCollection", **members, "features": features}).encode()


def csv_metres(orchard):
    """Trees in site metres, no rows told."""
    lines = ["x_m,y_m,tree_height_m"]
    lines += [f"{x!r},{y!r},{h!r}" for _, _, (x, y), _, h in floats(orchard)]
    return "\n".join(lines)


def csv_degrees(orchard):
    lines = ["latitude;longitude;tree_height_m"]
    for _, _, site, _, height in trees_of(orchard):
        longitude, latitude = degrees(orchard, site)
        lines.append(f"{latitude:.9f};{longitude:.9f};{height}".replace(".", ","))
    return "\n".join(lines)


def floats(orchard):
    for k, earth, site, ground, height in trees_of(orchard):
        yield k, earth.tolist(), site.tolist(), float(ground), float(height)


def kml_trees(orchard):
    marks = "".join(
        kml_mark(f"<Point><coordinates>{lon},{lat},0</coordinates></Point>", height_m=height)
        for (lon, lat), height in (
            (degrees(orchard, site), height) for _, _, site, _, height in trees_of(orchard)
        )
    )
    return kml(f"<Folder><name>trees</name>{marks}</Folder>")


def kml_mark(geometry, name="", **data):
    told = "".join(f'<Data name="{k}"><value>{v}</value></Data>' for k, v in data.items())
    told = f"<ExtendedData>{told}</ExtendedData>" if told else ""
    return f"<Placemark><name>{name}</name>{told}{geometry}</Placemark>"


def kml(body):
    text = f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{body}</Document></kml>'
    return ('<?xml version="1.0" encoding="UTF-8"?>' + text).encode()
