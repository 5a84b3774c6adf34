"""The result file of ./dev stress --json as a table: the worst that the pairs of each family showed."""


def families(entries):
    for entry in entries:
        yield [entry["family"], f"{entry['pairs']:,}", str(entry["failures"]), f"{entry['with_oracle']:,}",
               f"{entry['worst_error']:.0e}", f"{entry['worst_gap']:.0e}", str(entry["not_converged"]),
               str(entry["most_iterations"])]


def tables(result):
    """By name the head and the lines of each table that README.md shows."""
    return {"families": (["family", "pairs", "failures", "compared with the reference", "largest error / size",
                          "widest bounds / size", "not converged", "most iterations"], families(result["families"]))}


def facts(result):
    """By name what README.md says in its text."""
    seeds = result.get("seeds") or [result["seed"]]  # of several runs in one file, or of one
    return {"seeds": ", ".join(map(str, seeds)),
            "compared": f"{sum(entry['with_oracle'] for entry in result['families']):,}"}
