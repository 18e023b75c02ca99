"""Conceals an effect of known strength in a recording that was measured.

    conceal REC --add acid_transport --strength 0.005 --tau 120 --out OUT.csv --label OUT.json

Written are t_s, current_A (positive while charging) and voltage_V; the label reports what was added. tools/battery_sof_tools/concealment.py has the equations:
current_offset [A]; discharge_missed, charge_missed: share of one direction that the current sensor misses [1]; time_skew: voltage late by [s];
contact_resistance: step at --instant [ohm]; voltage_drift [V/h]; acid_transport: R LP_tau[i] [ohm]; ocv_soc: slope over charge [V/Ah];
high_rate_depletion: 0.15 V ln(1 - LP_tau[(-i)+] / i_L), strength 1/i_L [1/A]; memory_resistance: i LP_tau|i| [ohm/A], in no catalogue;
series_resistance [ohm], voltage_step (from the first sample on) [V], white_noise [V]: what the base circuit takes up, nothing to find.
"""
import argparse
import json
import math
import sys

from . import concealment as conceal
from . import recordings


def options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording")
    parser.add_argument("--add", required=True, choices=sorted(conceal.UNITS))
    parser.add_argument("--strength", type=float, required=True)
    parser.add_argument("--tau", type=float, default=120.0, help="[s], of the memory")
    parser.add_argument("--instant", type=float, help="[s] from the first sample, of the step; by default when 0.35 of all charge has passed")
    parser.add_argument("--time-column", default="t_s")
    parser.add_argument("--current-column", default="current_A")
    parser.add_argument("--voltage-column", default="voltage_V")
    parser.add_argument("--discharge-positive", action="store_true")
    parser.add_argument("--from", dest="start", type=float, default=-math.inf, help="[s]")
    parser.add_argument("--to", dest="end", type=float, default=math.inf, help="[s]")
    parser.add_argument("--out", required=True)
    parser.add_argument("--label", required=True)
    return parser.parse_args()


def main():
    args = options()
    t, i, u = recordings.read(args.recording, (args.time_column, args.current_column, args.voltage_column), args.discharge_positive, args.start, args.end)
    if len(t) < 3:
        print("conceal: fewer than three rows of {} hold time, current and voltage".format(args.recording), file=sys.stderr)
        return 1
    instant = conceal.instant_of_throughput(t, i, 0.35) if args.instant is None else t[0] + args.instant
    current, voltage = conceal.changed(args.add, t, i, u, args.strength, args.tau, instant)
    recordings.write(args.out, t, current, voltage, recordings.CAR)
    label = {"added": args.add, "named": conceal.NAMED[args.add], "strength": args.strength, "unit": conceal.UNITS[args.add],
             "tau_s": args.tau, "instant_s": instant, "added_rms_v": float((voltage - u).std())}
    if args.add not in conceal.CURRENT_SIDE:
        label["unexplained_rms_v"] = conceal.unexplained(args.add, t, i, voltage - u)
    with open(args.label, "w") as file:
        json.dump(label, file, indent=1)
    return 0
