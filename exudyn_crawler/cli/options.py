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
