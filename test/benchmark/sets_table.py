"""Makes tables of a result file of sets_benchmark: how much guaranteed distances lose beside the worst states that were found,
the boxes and certificates of proofs, and what all of it takes.
"""


def both(values, digits):
    """Returns the median and what 99 % of the values do not exceed."""
    return [f"{values[key]:,.{digits}f}" for key in ("median", "p99")]


def guarantees(entries):
    for entry in entries:
        yield [f"{entry['robot']}, {entry['uncertainty']}", f"{entry['pairs']:,}", *both(entry["loss"], 2), *both(entry["of_us"], 1),
               *both(entry["find_us"], 1)]


def free_motions(entries):
    for entry in entries:
        yield [entry["robot"], str(entry["pairs"]), f"{entry['bubbles']:.0f}", *both(entry["weights_ns"], 0), *both(entry["find_us"], 1)]


def proofs(entries):
    for entry in entries:
        undecided = entry["pairs"] - entry["proven"] - entry["refuted"]
        yield [entry["robot"], str(entry["pairs"]), f"{entry['proven']} / {entry['refuted']} / {undecided}",
               *(str(count) for count in entry["proven_within"]), f"{entry['boxes_of_proven']:,.0f}",
               f"{entry['most_boxes_of_proven']:,.0f}", f"{entry['boxes']:,}", f"{entry['seconds']:.2f} s",
               f"{entry['seconds_with_certificates']:.2f} s", f"{entry['certified']} / {entry['nodes']:,}"]


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    return {
        "guarantees": (["guaranteed distances", "pairs", "loss: median", "99 %", "of() [us]: median", "99 %",
                        "find() [us]: median", "99 %"], guarantees(result["guarantees"])),
        "free_motions": (["free motions", "pairs", "bubbles", "weights() [ns]: median", "99 %", "find() [us]: median", "99 %"],
                         free_motions(result["free_motions"])),
        "proofs": (["proofs", "pairs", "proven / refuted / undecided", *(f"proven with {most:,}" for most in result["few_boxes"]),
                    "boxes of the proven", "most of one", "of all", "time", "with certificates", "certificates / nodes"],
                   proofs(result["proofs"])),
    }


def note(result):
    return (f"{result['states']} states; loss: of the guaranteed distance over that of the worst state that was found; a proof "
            f"ends after\n{result['most_seconds']:g} s or {result['most_boxes']:,} boxes of a pair; processor time; {result['processor']}")
