"""What stands at the top of the report: where it comes from, and the numbers that are asked for first."""

import json
from collections.abc import Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import xarray as xr

from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.history.summary import BAND, bouncing, key_results

RECORD = "run.json"


def provenance(folder: Path, histories: Mapping[str, History]) -> list[str]:
    """Lines that say what the page shows: times of the cases, versions, and when run and page were made."""
    lines = [
        "; ".join(
            f"{name}: {one.duration:.4g} s, {one.time.size} stored times" for name, one in histories.items()
        )
    ]
    made = f"page made {datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
    record = _record(folder)
    told = record.get("commit")
    commit = [f"commit {told}"] if told and isinstance(told, str) else []
    with suppress(KeyError, TypeError, ValueError):
        finished = datetime.fromisoformat(record["finished"])
        made = f"{record['status']} {finished:%Y-%m-%d %H:%M} UTC after {record['wall_time_s']:.0f} s, {made}"
    programs = {
        f"{program} {version}"
        for one in histories.values()
        for program in ("exudyn-crawler", "exudyn")
        if (version := one.dataset.attrs.get(f"{program.replace('-', '_')}_version"))
    }
    return [line for line in (*lines, "; ".join([*sorted(programs, reverse=True), *commit, made])) if line]


def bouncing_lines(histories: Mapping[str, History]) -> list[str]:
    """A line for each case whose contact forces show that its shoes bounce."""
    found = {name: bouncing(history) for name, history in histories.items()}
    return [
        f"{name}: the shoes bounce at {one.frequency:.3g} Hz; the vertical force of the ground on a shoe "
        f"varies by {100.0 * one.size:.2g} % of its mean about that (root mean square), "
        f"{100.0 * one.share:.2g} % of all that varies above {BAND[0]:g} Hz"
        for name, one in found.items()
        if one is not None
    ]


def _record(folder: Path) -> dict[str, Any]:
    """Record of the run in a folder; nothing where it cannot be read."""
    try:
        found = json.loads((folder / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def key_rows(histories: Mapping[str, History], stresses: Mapping[str, xr.Dataset]) -> list[dict[str, Any]]:
    """Key results for the page: a row a result, with value and unit, where and when for each case."""
    rows: dict[str, dict[str, dict[str, str]]] = {}
    for name, history in histories.items():
        for _, one in key_results(history, stresses.get(name)).iterrows():
            where = ", ".join(filter(None, (one["of"], f"t = {one['at']:.4g} s")))
            rows.setdefault(one["result"], {})[name] = {
                "value": f"{one['value']:.4g} {one['unit']}",
                "where": where,
            }
    missing = {"value": "", "where": ""}
    return [
        {"result": result, "cells": [cells.get(name, missing) for name in histories]}
        for result, cells in rows.items()
    ]
