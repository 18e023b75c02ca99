"""The page's tables, and the errors behind its figures."""

import statistics as stats


def column(rows, setting, name, pulses=None):
    return [float(r[name]) for r in rows if r["setting"] == setting
            and (pulses is None or (int(r["pulses"]) > 0) == pulses)]


def settings_of(rows):
    return list(dict.fromkeys(r["setting"] for r in rows))


def factor_table(rows):
    lines = ["| setting | windows | Q_dyn, hour: worst, median, best [%] | below 60 % | below 85 % | "
             "crank error: median, worst [V] | above 0.03 V |", "|---|---|---|---|---|---|---|"]
    for name in settings_of(rows):
        q, crank = column(rows, name, "q_hour_percent"), column(rows, name, "crank_mae_v")
        lines.append("| {} | {} | {:.1f}, {:.1f}, {:.1f} | {} | {} | {:.3f}, {:.3f} | {} |".format(
            name, len(q), min(q), stats.median(q), max(q), sum(v < 60 for v in q), sum(v < 85 for v in q),
            stats.median(crank), max(crank), sum(v > 0.03 for v in crank)))
    return "\n".join(lines)


def worst_table(rows):
    lines = ["  | recording, window | setting | iterations | end | beta [1/V] | u_dc [V] | Q_dyn window [%] | Q_dyn hour [%] |",
             "  |---|---|---|---|---|---|---|---|"]
    for r in sorted(rows, key=lambda r: float(r["q_hour_percent"])):
        if float(r["q_hour_percent"]) < 84.0 and "W = " not in r["setting"]:
            lines.append("  | {}, {} | {} | {} | {} | {:.1f} | {:.2f} | {:.1f} | {:.1f} |".format(
                r["recording"].replace("data_set_1_", "seed ").replace(".csv", ""), r["window"], r["setting"],
                r["iterations"], r["status"], float(r["beta_per_v"]), float(r["u_dc_v"]),
                float(r["q_window_percent"]), float(r["q_hour_percent"])))
    return "\n".join(lines)


def pulse_table(rows):
    lines = ["| setting | window holds | windows | Q_dyn, hour: worst, median [%] | crank error: median, worst [V] |",
             "|---|---|---|---|---|"]
    for name in ("paper", "default", "with S1 and S3"):
        for pulses in (False, True):
            q, crank = column(rows, name, "q_hour_percent", pulses), column(rows, name, "crank_mae_v", pulses)
            if q:
                lines.append("| {} | {} | {} | {:.1f}, {:.1f} | {:.3f}, {:.3f} |".format(
                    name, "a pulse" if pulses else "no pulse", len(q), min(q), stats.median(q), stats.median(crank),
                    max(crank)))
    return "\n".join(lines)


def window_table(rows, recording):
    lines = ["| window | Q_dyn itself | Q_dyn hour | crank error, deviation [V] | r_discharge, r_charge [mOhm] | c2 [F] | "
             "beta [1/V] |", "|---|---|---|---|---|---|---|"]
    for r in rows:
        if r["recording"] == recording and r["setting"] == "default":
            lines.append("| {} | {:.1f} | {:.1f} | {:.3f}, {:.3f} | {:.2f}, {:.2f} | {:.0f} | {:.1f} |".format(
                r["window"], float(r["q_window_percent"]), float(r["q_hour_percent"]), float(r["crank_mae_v"]),
                float(r["crank_sd_v"]), 1e3 * float(r["r_discharge_ohm"]), 1e3 * float(r["r_charge_ohm"]),
                float(r["c2_f"]), float(r["beta_per_v"])))
    return "\n".join(lines)


def errors(data):
    return [u - p for u, p in zip(data["voltage_v"], data["predicted_v"])]


def long_charge_errors(data):
    """Measured minus predicted voltage at the end of each charge above 2 A that lasted over 20 s [V]."""
    found, begun = [], None
    e = errors(data)
    for n, (t, i) in enumerate(zip(data["time_s"], data["current_a"])):
        if i > 2.0 and begun is None:
            begun = t
        elif i <= 2.0 and begun is not None:
            if data["time_s"][n - 1] - begun > 20.0:
                found.append(stats.mean(e[max(n - 110, 0):n - 10]))
            begun = None
    return found


def stretch(data, start, end):
    keep = [n for n, t in enumerate(data["time_s"]) if start <= t <= end]
    return {name: [values[n] for n in keep] for name, values in data.items()}
