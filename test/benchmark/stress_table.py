"""Makes a table of the result file of ./dev stress --json: the worst that the pairs of each family showed."""


def families(entries):
    for entry in entries:
        yield [entry["family"], f"{entry['pairs']:,}", str(entry["failures"]), f"{entry['with_oracle']:,}",
               f"{entry['worst_error']:.0e}", f"{entry['worst_gap']:.0e}", str(entry["not_converged"]),
               str(entry["most_iterations"])]


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    return {"families": (["family", "pairs", "failures", "compared with the reference", "largest error / size",
                          "widest bounds / size", "not converged", "most iterations"], families(result["families"]))}


def facts(result):
    """Returns what TABLES.md says in its text by name."""
    seeds = result.get("seeds") or [result["seed"]]  # of several runs in one file, or of one
    return {"seeds": ", ".join(map(str, seeds)),
            "compared": f"{sum(entry['with_oracle'] for entry in result['families']):,}"}
