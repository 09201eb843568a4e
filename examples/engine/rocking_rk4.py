"""An engine that another package brings: Housner's equation (1963) by Runge-Kutta steps in NumPy.

theta'' = -p^2 (sin(s alpha - theta) + a / g cos(s alpha - theta)), s the side it leans to. Steps of
fourth order are cut at impacts to second order; a step of the base's velocity moves to the start of
its time step, which makes the whole first order. It does not ask whether the block would slide.
"""

import dataclasses
import math
from typing import Annotated, ClassVar

import numpy as np

from warprock.engines.base import AbstractEngine
from warprock.engines.decoding import respond
from warprock.engines.places import planar_places
from warprock.model import rocking
from warprock.model.response import Outcome, Status
from warprock.settings.setting import SettingKey
from warprock.units import GRAVITY


@dataclasses.dataclass(frozen=True)
class RungeKuttaSettings:
    """Settings of `rk4`: what [engines.rk4] of a case may hold."""

    drawn: ClassVar[tuple[str, str]] = ("sky", "h")
    time_step: Annotated[float, SettingKey("the time step", 1e-6, 1e-2, "s")] = 2e-3

    def halved(self):
        """The same with half of the time step, by which `run` estimates errors."""
        return self.with_step_scaled(0.5)

    def with_step_scaled(self, factor):
        """The same with the time step multiplied by a factor."""
        return dataclasses.replace(self, time_step=factor * self.time_step)


class RungeKutta(AbstractEngine):
    """Housner's equation by Runge-Kutta steps of fourth order, cut at impacts."""

    name = "rk4"
    settings_type = RungeKuttaSettings
    order = 1
    slides = False
    restitution = None  # it follows the angular restitution of the lanes

    @classmethod
    def declines(cls, scene):
        """Why it cannot run a scene besides what its attributes say; None if it can."""
        return "rk4 runs single blocks, and the case has a stack" if scene.stacked else None

    def run(self, lanes, motions, times):
        """A response of lanes on their motions; see `AbstractEngine.run`."""
        real, count = np.dtype(self.target.precision).type, lanes.lane_count
        steps = math.ceil(times.duration / self.settings.time_step * (1.0 - 1e-12))
        step = times.duration / steps
        ticks = 0.5 * step * np.arange(2 * steps + 1)
        pull = np.array([motions.acceleration(ticks, lane) for lane in range(count)], real).T
        kick = np.zeros((steps, count), real)
        for lane in range(count):
            for part in motions.segments(lane):
                if part.velocity_step and part.start < times.duration:
                    kick[int(part.start / step), lane] += part.velocity_step
        size = lanes.width, lanes.height
        alpha = lanes.slenderness_angle.astype(real)
        square = (rocking.frequency_parameter(*size) ** 2).astype(real)
        keep = lanes.angular_restitution.astype(real)
        inertia = 4.0 / 3.0 * lanes.mass * rocking.half_diagonal(*size) ** 2
        theta, rate = lanes.rotation_start.astype(real), np.zeros(count, real)
        moving, fallen = theta != 0.0, np.zeros(count, bool)
        uplift, rest = np.where(moving, 0.0, np.nan), np.where(moving, np.nan, 0.0)
        peak, peak_time, lost = np.abs(theta).astype(float), np.zeros(count), np.zeros(count)
        impacts, seen = np.zeros(count, int), [theta[:, None]]
        within = np.ceil(times.times / step - 1e-9).astype(int) - 1

        def bend(turned, side, acceleration):
            lever = side * alpha - turned
            return -square * (np.sin(lever) + acceleration / real(GRAVITY) * np.cos(lever))

        for k in range(steps):
            now, before = k * step, theta
            start, middle, end = pull[2 * k : 2 * k + 3]
            rate = rate - square / real(GRAVITY) * np.cos(alpha - np.abs(theta)) * kick[k] * ~fallen
            lifts = ~moving & ((np.abs(start) > GRAVITY * np.tan(alpha)) | (rate != 0.0))
            moving = moving | lifts
            uplift = np.where(lifts & np.isnan(uplift), now, uplift)
            rest = np.where(lifts, np.nan, rest)
            side = np.sign(np.where(theta != 0.0, theta, np.where(rate != 0.0, rate, -start)))
            h = np.where(moving & ~fallen, real(step), real(0.0))
            first = bend(theta, side, start)
            second = bend(theta + h / 2 * rate, side, middle)
            third = bend(theta + h / 2 * rate + h * h / 4 * first, side, middle)
            fourth = bend(theta + h * rate + h * h / 2 * second, side, end)
            after = theta + h * rate + h * h / 6 * (first + second + third)
            rate_after = rate + h / 6 * (first + 2 * second + 2 * third + fourth)
            struck = moving & ~fallen & (side * after <= 0.0)
            # Up to the impact as if with one acceleration; what is left of the step, from there.
            high, down, steady = side * theta, side * rate, side * (rate_after - rate) / step
            speed = np.sqrt(np.maximum(down**2 - 2 * steady * high, 0)) - down
            spent = np.minimum(2 * high / np.where(speed > 0, speed, 1), h)
            at, beyond = rate + side * steady * spent, h - spent
            left = np.where(struck, keep * at, 0)
            rests = struck & (np.abs(left) < square * np.sin(alpha) * real(step))
            left = np.where(rests, real(0.0), left)
            lost += np.where(struck, 0.5 * inertia * (at**2 - left**2), 0.0)
            turns = np.where(rests, 0, bend(0 * theta, -side, end))
            theta = np.where(struck, left * beyond + turns * beyond**2 / 2, after)
            rate = np.where(struck, left + turns * beyond, rate_after)
            impacts, moving = impacts + struck, moving & ~rests
            rest = np.where(rests, now + step, rest)
            falls = np.abs(theta) >= np.pi / 2
            fallen, rate = fallen | falls, np.where(falls, real(0.0), rate)
            theta = np.where(falls, np.sign(theta) * real(np.pi / 2), theta)
            higher = ~(np.abs(theta) <= peak)
            peak_time = np.where(higher, now + step, peak_time)
            peak = np.where(higher, np.where(falls, np.pi / 2, np.abs(theta)), peak)
            part = (times.times[within == k] - now) / step
            seen.append(before[:, None] + (theta - before)[:, None] * part)
        outcome = np.where(moving, Outcome.ROCKING, Outcome.AT_REST)
        zero = np.zeros(count)
        fields = {
            "peak_rotation": peak[:, None],
            "peak_time": peak_time[:, None],
            "residual_slide": zero[:, None],
            "peak_slide": zero[:, None],
            "outcome": np.where(fallen, Outcome.OVERTURNED, outcome),
            "status": np.full(count, Status.OK),
            "impact_count": impacts,
            "uplift_time": uplift,
            "rest_time": rest,
            "peak_penetration": zero,
            "energy_lost": lost,
            "step_count": np.full(count, steps),
        }
        if times.interval is not None:
            fields["rotation"] = np.concatenate(seen, axis=1)[:, None, :]
            if times.places:
                fields |= planar_places(lanes, fields["rotation"], None)
        return respond(self.name, lanes, fields, times)
