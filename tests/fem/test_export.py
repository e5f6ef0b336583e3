"""Export to ParaView."""

from pathlib import Path

import meshio
import numpy as np

import fem


def test_vtu_of_a_frame(tmp_path: Path, small: fem.ReducedBody, history: np.ndarray) -> None:
    fem.write_frame_vtu(tmp_path / "frame.vtu", small, history[3])
    fem.write_modes_vtu(tmp_path / "modes.vtu", small, [0, 2])
    frame = meshio.read(tmp_path / "frame.vtu")
    np.testing.assert_allclose(frame.point_data["von mises"], small.von_mises(history[3])[0], rtol=1e-12)
    np.testing.assert_allclose(
        meshio.read(tmp_path / "modes.vtu").point_data["stress 2"], small.stress_modes[:, :, 2]
    )
