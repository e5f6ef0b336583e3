"""Options that commands share."""

from pathlib import Path
from typing import Annotated

import typer

RESULTS = Path("results")
"""Folder of the folders of runs and studies, where a command names no other."""

Run = Annotated[Path, typer.Argument(help="folder of a run, or its history (NetCDF)", metavar="RUN")]
Out = Annotated[Path, typer.Option(help="folder for the results")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace earlier results")]
Debug = Annotated[bool, typer.Option("--debug", help="show the traceback of an error")]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", help="value in place of the file's, as terrain.spring_stiffness=1e7; repeatable"),
]
