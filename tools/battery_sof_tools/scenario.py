"""What the benchmarks call a kind of scenario, and what `draw_scenario` calls it.

The benchmarks' words are part of their seeds and of plans that are kept, so they stay what they are.
"""

KIND_OF = {"null": "base_control", "structural_null": "structural_control", "porous_null": "porous_control",
           "decoy": "instrument_fault", "unknown": "unlisted_law"}  # of the catalogue's; the others are called alike
LAW_KIND_OF = {"null": "control", "imperfect_null": "control_with_recorder", "other_form": "out_of_catalogue"}


def as_planned(label):
    """A law's or a control's label in the benchmarks' words: kind, family, form. Labels in them stay as they are."""
    words = {kind: word for word, kind in LAW_KIND_OF.items()}
    if label["kind"] not in words:
        return label
    return {**label, "kind": words[label["kind"]], "family": label.get("mechanism"), "form": label.get("id")}
