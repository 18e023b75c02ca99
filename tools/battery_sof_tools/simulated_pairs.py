"""Pairs of trips of one simulated start-stop car: sound twice, or with a change of the battery before the second (change_study.py).

A trip is half an hour or more at one sample a second. The alternator holds the voltage, what it charges follows from the surface of dissolving crystals,
and the channels are written in the steps of the sensors of a start-stop car. Two sound trips differ by drive, charge, temperature and set point.
"""

import collections
import os
import random

from .files import write_json
from .recordings import read_plain
from .sof import run

# A change of the battery, and what the answer may call it: nothing where no candidate is of that kind.
BatteryChange = collections.namedtuple("BatteryChange", "name effect")
BATTERY_CHANGES = (BatteryChange("resistance +30 %", "contact_resistance"), BatteryChange("capacity -30 %", None), BatteryChange("acceptance halved", None),
                   BatteryChange("gassing", None), BatteryChange("15 K warmer", None))
RESISTANCES = ("r_ohmic_ohm", "r1_charge_ohm", "r1_discharge_ohm")


def drawn_battery(dice):
    return {"capacity_ah": dice.uniform(50.0, 90.0), "r_ohmic_ohm": dice.uniform(0.0025, 0.0045), "r1_charge_ohm": dice.uniform(0.004, 0.007),
            "r1_discharge_ohm": dice.uniform(0.003, 0.0045), "i0_a": dice.uniform(0.5, 2.0), "cpe2_capacitance_f": dice.uniform(500.0, 1500.0),
            "lead_ion_limit_a": dice.uniform(1.5, 6.0), "lead_ion_time_s": dice.uniform(3.0, 12.0)}


def drawn_crystals(dice):
    return {"sulphate_crystals": True, "crystal_supply": dice.uniform(40.0, 160.0), "crystal_nuclei_ah": dice.uniform(0.01, 0.05), "crystal_ripening_s": dice.uniform(600.0, 3600.0)}


def drawn_car(dice):
    """What both trips of a car have in common."""
    return {"battery": drawn_battery(dice), "additions": drawn_crystals(dice), "soc": dice.uniform(0.72, 0.88), "temperature_degc": dice.uniform(5.0, 30.0), "voltage_limit_v": dice.uniform(14.0, 14.6)}


def drawn_phases(duration_s, highest_v, dice):
    """Of a town with an alternator whose set point follows the driving: high while braking, low while the engine works, off while it stands."""
    stop_a, wanted_a, phases, left = dice.uniform(15.0, 30.0), dice.uniform(70.0, 120.0), [], duration_s

    def add(duration, current, limit=None):
        nonlocal left
        left -= duration
        phases.append({"duration_s": round(duration, 3), "current_a": round(current, 2), **({} if limit is None else {"voltage_limit_v": limit})})

    while left > 0.0:
        add(dice.uniform(5.0, 40.0), -stop_a * dice.uniform(0.6, 1.4))
        add(0.12, -dice.uniform(230.0, 300.0))
        add(dice.uniform(0.3, 0.7), -dice.uniform(120.0, 180.0))
        for _ in range(dice.randint(1, 4)):
            add(dice.uniform(3.0, 20.0), -dice.uniform(0.0, 25.0))
            add(dice.uniform(10.0, 90.0), wanted_a, limit=highest_v - dice.uniform(0.4, 1.6))
            if dice.random() < 0.8:
                add(dice.uniform(4.0, 20.0), wanted_a, limit=highest_v)
    return phases


def drawn_trip(car, dice):
    """A scenario of `sof simulate`: a sound trip of a car."""
    duration_s = round(dice.uniform(1800.0, 3600.0))
    highest_v = car["voltage_limit_v"] + dice.uniform(-0.1, 0.1)
    return {"name": "trip", "seed": dice.randrange(10**9), "duration_s": duration_s, "voltage_limit_v": highest_v,
            "soc": car["soc"] + dice.uniform(-0.05, 0.05), "temperature_degc": car["temperature_degc"] + dice.uniform(-5.0, 5.0),
            "effects": {"charge_acceptance": True, "gassing": "tafel"}, "battery": dict(car["battery"]), "additions": dict(car["additions"]),
            "acquisition": {"sample_rate_hz": 1.0, "cutoff_hz": 0.4, "voltage_white_v": 0.004, "current_white_a": 0.05, "voltage_step_v": 0.025, "current_step_a": 0.1},
            "profile": {"kind": "phases", "phases": drawn_phases(duration_s, highest_v, dice)}}


def with_change(trip, name):
    """The scenario with a battery that has changed."""
    battery = dict(trip["battery"])
    if name == "resistance +30 %":
        battery.update({key: 1.3 * battery[key] for key in RESISTANCES})
    elif name == "capacity -30 %":
        battery.update({key: 0.7 * battery[key] for key in ("capacity_ah", "cpe2_capacitance_f")})
    elif name == "acceptance halved":
        battery["lead_ion_limit_a"] *= 0.5  # of the crystals' supply, too, which is counted in it
    elif name == "gassing":
        battery["gas_current_a"] = 3.0
    elif name == "15 K warmer":
        return dict(trip, temperature_degc=trip["temperature_degc"] + 15.0)
    return dict(trip, battery=battery)


def drawn_pair(seed):
    """(then, now): scenarios of two sound trips of a car."""
    dice = random.Random(seed)
    car = drawn_car(dice)
    return drawn_trip(car, dice), drawn_trip(car, dice)


def recorded(binary, trip, folder):
    """(t, i, u) of a scenario."""
    scenario, recording = (os.path.join(folder, name) for name in ("trip.yaml", "trip.csv"))
    write_json(scenario, trip)  # which is YAML, too
    run([binary, "simulate", scenario, recording])
    return read_plain(recording)
