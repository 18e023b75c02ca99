"""The diagrams: states of the node, a query, the energy manager's loop."""

from .svg import SOFT, Drawing, Sequence


def node_states():
    d = Drawing(1000, 340, "States of battery_sof_node")
    d.frame(255, 14, 731, 312)
    d.box(100, 170, 160, 56, "NO_DATA", "no sample for 5 s")
    d.box(370, 90, 180, 56, "population", "known of batteries", "#e6f4ea")
    d.box(370, 240, 180, 56, "previous_trip", "the saved model", "#e6f4ea")
    d.box(800, 170, 180, 56, "this_trip", "a fitted window", "#e6f4ea")
    d.path("M180 158 H225 V90 H278")
    d.text(216, 70, "first sample", size=12)
    d.path("M180 182 H225 V240 H278")
    d.text(150, 262, "first sample,\nwith a state file", size=12)
    d.path("M370 212 V120")
    d.text(380, 160, "another battery,\nor its numbers overflow", anchor="start", size=12)
    d.path("M460 90 H800 V140")
    d.text(640, 70, "fit accepted: 240 s of samples (1 Hz: 900 s)", size=12)
    d.path("M460 240 H760 V200")
    d.text(600, 260, "fit accepted", size=12)
    d.path("M820 198 C820 250 870 250 870 200")
    d.text(845, 262, "new fit every 600 s", size=12)
    d.text(275, 315, "All answer (READY).", anchor="start", color=SOFT, size=12)
    return d.whole()


def query():
    s = Sequence("One query: samples keep coming while it is answered", ("battery sensor", "battery_sof_node", "your node"), (110, 450, 800), 8.0)
    s.message(0, 1, "battery_state, 1 to 1000 Hz")
    s.note(1, "every sample: the state\nof the model follows")
    s.message(2, 1, "~predict_cranking (i_load, t_stop, i_cranking)")
    s.note(1, "copies model and state,\nsimulates stop and crank")
    s.message(0, 1, "next samples are not delayed")
    s.message(1, 2, "u_min, lower, upper, capable, valid, code", dashed=True)
    s.note(2, "decides only\nif valid is true")
    return s.whole()


def energy_manager():
    s = Sequence("The energy manager during a stop", ("battery_sof_node", "energy_manager", "engine control"), (110, 450, 800), 8.4)
    s.message(0, 1, "~status, 1 Hz")
    s.message(2, 1, "engine_off: true")
    s.message(1, 0, "three queries, 10 times a second")
    s.message(0, 1, "crank, stop time, charge with 90 % intervals", dashed=True)
    s.note(1, "all valid, and the lower\nbounds are high enough?")
    s.message(1, 2, "~decision: may_stop, or restart with a reason")
    s.message(2, 1, "engine_off: false")
    s.message(0, 1, "past_cranks: measured and predicted")
    return s.whole()


DIAGRAMS = {"node_states.svg": node_states, "query_sequence.svg": query, "energy_manager_sequence.svg": energy_manager}
