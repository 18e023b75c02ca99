"""Asks a running battery_sof_node its what-if questions and prints the answers as an engineer reads them."""

import math

import rospy
from battery_sof.msg import SofStatus
from battery_sof.srv import PredictChargeAcceptance, PredictCranking, PredictStopTime, SimulateProfile

from .stress.ros import NODE, perform

U_REQUIRED = 7.2  # [V], paper, section II


def service(name, kind):
    rospy.wait_for_service(NODE + "/" + name, timeout=20.0)
    return rospy.ServiceProxy(NODE + "/" + name, kind)


def identify():
    answer = perform("identify")
    print("~identify: {} ({})".format("accepted" if answer.accepted else "not accepted", answer.message))
    model = answer.model
    for name, value, std, unit in zip(model.names, model.values, model.std, model.units):
        print("    {:<12} {:>10.5g} +- {:<8.2g} {}".format(name, value, std, unit))


def assurance(answer, holds):
    return "not valid" if not answer.valid else "holds" if holds else "not assured"


def cranking():
    ask = service("predict_cranking", PredictCranking)
    print("1. ~predict_cranking: will a crank of 1 s at -200 A hold {} V after a stop at -25 A?".format(U_REQUIRED))
    for t_stop in (0.0, 10.0, 30.0, 60.0, 300.0):
        a = ask(i_load=-25.0, t_stop=t_stop, i_cranking=-200.0, t_cranking=1.0, u_required=U_REQUIRED)
        print("    stop {:>5.0f} s: lowest {:.2f} V, 90 % between {:.2f} and {:.2f} V: {}".format(
            t_stop, a.u_min, a.lower, a.upper, assurance(a, a.capable)))


def stop_time():
    ask = service("predict_stop_time", PredictStopTime)
    print("2. ~predict_stop_time: how long may the engine stay off at -25 A so that such a crank holds a voltage?")
    for u_required in (U_REQUIRED, 11.4, 11.5, 12.5):
        a = ask(i_load=-25.0, i_cranking=-200.0, t_cranking=1.0, u_required=u_required)
        end = "no end" if math.isinf(a.upper) else "{:.0f} s".format(a.upper)
        least = {"finite": "", "at_least": "at least "}.get(a.outcome)
        found = a.outcome if least is None else "{}{:.0f} s, 90 % between {:.0f} s and {}".format(
            least, a.t_stop, a.lower, end)
        print("    {:>5.1f} V: {}: {}".format(u_required, found, assurance(a, a.lower > 0.0)))


def charge():
    ask = service("predict_charge_acceptance", PredictChargeAcceptance)
    print("3. ~predict_charge_acceptance: what current would it take for 10 s at a held voltage, at most 120 A?")
    for u_boost in (13.0, 13.4, 13.8, 14.2):
        a = ask(u_boost=u_boost, t_sof2=10.0, i_limit=120.0)
        print("    {:>5.1f} V: {:.0f} A, 90 % between {:.0f} and {:.0f} A: {}".format(
            u_boost, a.i_boost, a.lower, a.upper, assurance(a, a.lower > 0.0)))


def profile():
    ask = service("simulate_profile", SimulateProfile)
    time = [0.0, 20.0, 20.1, 20.2, 21.0, 21.1, 30.0]
    current = [-25.0, -25.0, -250.0, -150.0, -150.0, 30.0, 30.0]
    answer = ask(time, current)
    print("~simulate_profile: a stop, a crank, then charging ({})".format(answer.message))
    for t, i, u, low, high in zip(time, current, answer.voltage, answer.lower, answer.upper):
        print("    {:>5.1f} s {:>7.0f} A: {:.3f} V  [{:.3f}, {:.3f}]".format(t, i, u, low, high))


def refusal():
    answer = service("predict_cranking", PredictCranking)(i_load=-25.0, t_stop=30.0, i_cranking=200.0, t_cranking=1.0,
                                                          u_required=math.nan)
    print("a query with the wrong sign: code {}, {}".format(answer.code, answer.message))


def main():
    rospy.init_node("demo_questions", anonymous=True)
    status = rospy.wait_for_message(NODE + "/status", SofStatus, timeout=20.0)
    states = {getattr(SofStatus, name): name for name in ("NO_DATA", "COLLECTING", "IDENTIFYING", "READY")}
    print("~status: {}, model {:.0f} s old, Q_dyn of the running back-test {:.1f} %, window quality {:.2f}".format(
        states[status.state], status.model_age, status.backtest_q_dyn_percent, status.window_quality))
    cranks, charges = status.past_cranks, status.past_charges
    print("    so far {} cranks missed by {:.3f} V, {} charges by {:.1f} A; inside their 90 % intervals: {:.0f} %, {:.0f} %".format(
        cranks.count, cranks.mean_abs_error, charges.count, charges.mean_abs_error, 100.0 * cranks.coverage, 100.0 * charges.coverage))
    cranking()
    stop_time()
    charge()
    profile()
    refusal()
    identify()
