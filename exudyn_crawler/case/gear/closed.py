"""Closed gear: a track goes round tumbler, idler and rollers of its side frame."""

import itertools
import math
from collections.abc import Iterator
from typing import ClassVar, Literal, Self

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear.assembled import Assembled, assembled
from exudyn_crawler.case.gear.base import POSTS, Whole
from exudyn_crawler.case.gear.closed_frame import ClosedFrame
from exudyn_crawler.case.gear.deflections import PULL, SIDEWAYS, TOOTH, LoadedContact, idler_spring
from exudyn_crawler.case.gear.running_gear import implausible_rails
from exudyn_crawler.case.parameters import assembly, base, sizes
from exudyn_crawler.case.parameters.closed_track import Idler, Tumbler
from exudyn_crawler.case.parameters.track import MIDWAY, Shoe, Track
from exudyn_crawler.case.ph4100c import GRAVITY
from exudyn_crawler.settings.parameters import Errors, option

MISFIT = 0.01  # greatest plausible difference of the tumbler's pitch, fraction of the chain's, new or worn
SLIDE_MARGIN = 0.02  # m, greatest distance from a rail's ends at which a slide's round line still touches it


class Closed(ClosedFrame):
    """Track that is closed round a side frame, whose tumbler drives the chain and whose idler tightens it."""

    kind: Literal["closed"] = option("closed track around its side frame", "closed")

    quantities: ClassVar[frozenset[str]] = frozenset({"frame", "closed"})
    chain_parts: ClassVar[tuple[str, ...]] = ("tumbler", "idler")
    loops: ClassVar[int] = 1
    phrase: ClassVar[str] = "Side frame of {carried} t with its wheels on a closed track of {shoes} shoes"
    # a joint off the middle would carry a moment of the whole tension in a tight chain
    rigid_joint: ClassVar[str] = MIDWAY

    @classmethod
    def ph4100c(cls) -> Self:
        """Return the closed track of the P&H 4100C BOSS; `case.ph4100c` marks assumed values."""
        return cls(tumbler=Tumbler.ph4100c(), idler=Idler.ph4100c(), **ph4100c.CLOSED_TRACK)

    @property
    def tumblers(self) -> tuple[str, ...]:
        """Names of the tumblers."""
        return self._on_tracks(["tumbler"])

    @property
    def sliding_idlers(self) -> tuple[str, ...]:
        """Names of the idlers that slide on springs."""
        return self._on_tracks([] if self.idler.slide is None else ["idler"])

    @property
    def holds(self) -> tuple[int, ...]:
        """Coordinates of the side frame with a hold: all of them on posts."""
        return POSTS if self.support == "posts" else super().holds

    @property
    def pin_compliance(self) -> float:
        """Lateral compliance of the pins: m/N sideways, rad/(N m) in yaw and roll."""
        return self.compliance

    @property
    def flange(self) -> tuple[float, float, float]:
        """Play (m), stiffness (N/m) and damping (N s/m) of the flanges of a wheel."""
        return self.guide_play, self.guide_stiffness, self.guide_damping

    @property
    def flange_height(self) -> float:
        """Height of the flanges above a tread, m."""
        return self.guide_height

    @property
    def slide_places(self) -> tuple[base.Three, ...]:
        """Slides: x of rear and front end, z of the top, m."""
        return self.slides

    def assembled(self, case: Whole) -> Assembled:
        """Return the start of one track; raises `assembly.MisfitError` if its chain does not close."""
        return assembled(self, case.shoe, self.loop(case.track))

    def shoe_reference(self, case: Whole) -> np.ndarray:
        """Return the COMs (m, global) and angles (rad) of the shoes at t = 0: array (shoes, 6)."""
        return self.beside(self.assembled(case).shoes)

    def frame_start(self, case: Whole) -> np.ndarray:
        """Return the origin of side frame or machine at t = 0, on rails that have not settled: (3,), m."""
        return self.assembled(case).frame - np.array([0.0, self.middles[0], 0.0])

    def tumbler_reference(self, case: Whole) -> np.ndarray:
        """Return the tumblers' centres (m, global) and angles (rad) at t = 0: array (tracks, 6)."""
        return self.beside(self.assembled(case).tumbler[None])

    def idler_reference(self, case: Whole) -> np.ndarray:
        """Return the idlers' centres (m, global) and angles (rad) at t = 0: array (tracks, 6)."""
        x, z = self.idler.place
        start = self.assembled(case)
        center = start.frame + np.array([x + start.take_up, 0.0, z])
        return self.beside(np.array([[*center, 0.0, 0.0, 0.0]]))

    def beside(self, rows: np.ndarray) -> np.ndarray:
        """Return the rows (n, 6) of the first track, global, moved to every track: array (tracks n, 6)."""
        middles = self.middles
        rows_of_all = np.tile(rows, (self.tracks, 1))
        rows_of_all[:, 1] += np.repeat(middles - middles[0], len(rows))
        return rows_of_all

    def first_wheels(self, case: Whole) -> np.ndarray:
        """Return the wheels of one track at the take-up of the assembled chain, see `wheels`."""
        return self.wheels(self.assembled(case).take_up)

    def arm_reference(self, case: Whole) -> np.ndarray:
        """Return the arms' pivots (m, global) and angles (rad) at t = 0: array (tracks * arms, 6)."""
        reference = super().arm_reference(case)
        angles = self.arms_lifted(self.assembled(case).sunk)[:, 1]
        reference[:, 4] = np.tile(angles, self.tracks)
        return reference

    def extent(self, case: Whole) -> tuple[float, float, float]:
        """Return x of tumbler and idler, and the least z among tumbler, carriers and slides, m."""
        rear, height = self.tumbler.place
        front = self.idler.place[0] + self.assembled(case).take_up
        return rear, front, min([height, *(z for _, z in self.upper.values())])

    def shoes_by_strips(self, bends: np.ndarray) -> np.ndarray:
        """Return the shoes, from 0, with every strip of a tread in a history: the flexible ones."""
        return np.flatnonzero(bends)

    def active(self, driven: bool, turned: bool, drawn: bool = False) -> np.ndarray:
        """Return the active constraints of the drive, array (2,): only that of a drawbar."""
        return np.array([driven and drawn, False], dtype=float)

    def motors(self, speeds: np.ndarray, chain: Track) -> np.ndarray:
        """Return the motors' speeds (rad/s) for track speeds (tracks,), m/s; zero for sliding idlers."""
        still = np.zeros(len(self.sliding_idlers))
        return np.concatenate((speeds / self.travel_per_angle(chain), still))

    def engine_errors(self) -> Errors:
        """Yield an error for each part that is not made of Exudyn's items."""
        engine = "with formulation 'engine'"
        if self.idler.slide is not None:
            yield f"gear.idler.tensioner and gear.idler.recoil must be none {engine}"
        if self.play is not None:
            yield f"gear.play must be none {engine}"

    def track_errors(self, shoe: Shoe, chain: Track) -> Errors:
        """Yield an error for each property of rails and chain that does not fit the wheels."""
        rails = shoe.roller_path
        if rails.height <= chain.pin_height:
            yield f"shoe.rails.height must be above the pins at {chain.pin_height} m, got {rails.height}"
        x = np.sort([x for x, _ in self.upper.values()])
        length = rails.front - rails.rear
        near = x[2:] - x[:-2] < length + SLIDE_MARGIN
        if self.slides and np.any(near):
            places = ", ".join(f"{place:.4g}" for place in x[near.argmax() :][:3])
            yield (
                f"slide_step, slides and carriers must leave every rail, which is {length:.4g} m long, on "
                f"two of their lines at once, got three at x = {places} m; "
                f"lines at least {0.5 * (length + SLIDE_MARGIN):.3g} m apart do"
            )
        yield from self.tumbler.tooth_errors(chain)
        try:
            start = assembled(self, shoe, chain)
        except assembly.MisfitError as error:
            yield f"gear: {error}"
            return
        yield from (f"gear: {error}" for error in self._overlaps(chain, start.take_up))

    def _overlaps(self, chain: Track, take_up: float) -> Errors:
        """Yield an error for each overlap of rollers, idler, carriers and the tumbler inside its gaps."""
        profile = self.tumbler.profile(chain)
        labelled = zip(self.wheel_labels, self.wheels(take_up).tolist(), strict=True)
        wheels = [sizes.Round(label.words, *wheel) for label, wheel in labelled if label.kind != "slide"]
        yield from sizes.overlap_errors(
            [sizes.Round("tumbler", *self.tumbler.place, profile.center - profile.arc), *wheels]
        )

    def implausible(self, shoe: Shoe, chain: Track) -> Iterator[str]:
        """Yield a warning for each inertia, contact and pitch of teeth that no known machine has."""
        tumbler = self.tumbler
        radius = tumbler.tip_radius(chain.pitch)
        turning = "gear.tumbler", tumbler.mass, tumbler.inertia
        yield from sizes.wide_inertia(*turning, (radius, 0.5 * shoe.width, radius))
        yield from sizes.thin_inertia(*turning)
        yield from super().implausible(shoe, chain)
        yield from self.implausible_treads(self.roller_radius)
        yield from self._odd_lugs()
        yield from self._odd_contacts(shoe, chain)
        yield from self._other_pitch(chain)
        yield from implausible_rails(shoe, chain, self.roller_radius)

    def _odd_lugs(self) -> Iterator[str]:
        """Yield a warning for lugs of a shoe that overlap each other."""
        tumbler = self.tumbler
        apart = min((math.dist(*pair) for pair in itertools.combinations(tumbler.lugs, 2)), default=math.inf)
        if apart < 2.0 * tumbler.lug_radius:
            lugs = f"lugs of {1e3 * tumbler.lug_radius:.4g} mm radius stand {1e3 * apart:.4g} mm apart"
            yield f"gear.tumbler.lugs: {lugs} and overlap; is a sign of their x missing?"

    def _odd_contacts(self, shoe: Shoe, chain: Track) -> Iterator[str]:
        """Yield a warning for implausible deflection or damping of teeth, flanges and the idler's spring."""
        tumbler = self.tumbler
        weight = self.carried_mass * GRAVITY / self.tracks
        pull = 0.5 * PULL * weight
        law = tumbler.stiffness, tumbler.exponent, tumbler.damping
        words = "a tooth"
        share = "a pull of half the weight on its track, on both sides"
        tooth = LoadedContact("gear.tumbler.", words, pull, share, *law, tumbler.mass)
        yield from tooth.implausible(TOOTH * tumbler.lug_radius, f"{TOOTH:g} of a lug's radius")
        aside = SIDEWAYS * self.roller_load
        words = "a roller's flange"
        share = f"{SIDEWAYS:g} of its roller's even share of the weight"
        law = self.guide_stiffness, 1.0, self.guide_damping
        flange = LoadedContact("gear.guide_", words, aside, share, *law, shoe.mass)
        yield from flange.implausible(self.offset_limit, "gear.offset_limit, where shoes come off")
        spring = self.idler.slide
        if spring is not None:
            kind = "tensioner" if self.idler.recoil is None else "recoil"
            half = 0.5 * shoe.mass * self.loop(chain).shoe_count
            yield from idler_spring(f"gear.idler.{kind}", spring, chain.pitch, half)

    def _other_pitch(self, chain: Track) -> Iterator[str]:
        """Yield a warning if the tumbler's pitch differs from that of the chain, new or worn."""
        pitch = self.tumbler.pitch
        new = chain.pitch
        worn = self.chain_pitch(chain)
        if pitch is None or (1.0 - MISFIT) * min(new, worn) <= pitch <= (1.0 + MISFIT) * max(new, worn):
            return
        fits = new / (2.0 * np.sin(np.pi / self.tumbler.shoes_per_turn))
        turn = "pi" if self.tumbler.gaps_per_shoe == 1 else f"{self.tumbler.gaps_per_shoe} pi"
        pitches = f"{new:.4g} m" if worn == new else f"{new:.4g} m new and {worn:.4g} m worn"
        yield (
            f"gear.tumbler: its pitch, 2 pitch_radius sin({turn} / teeth), is {pitch:.4g} m, the chain's "
            f"{pitches}: shoes climb its {self.tumbler.teeth} teeth and stretch the chain; "
            f"pitch_radius none, or {fits:.4g} m, fits"
        )
