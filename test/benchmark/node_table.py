"""Makes tables of a result file of node_benchmark: round trips of each service beside an empty one, batches beside
their computation, how long a changed object needs to its level, and how regularly the monitor runs.
"""


def number(value):
    return f"{value:.1f}" if value < 100 else f"{value:,.0f}"


def time(microseconds):
    return f"{number(microseconds)} us" if microseconds < 1000 else f"{microseconds / 1000:.3g} ms"


def times(entry):
    return " / ".join(time(entry[key]) for key in ("median_us", "p99_us", "p999_us"))


def more(value, base):
    return f"{value / base - 1:+.0%}" if base else "-"


def spread(figures, name):
    return " / ".join(time(figures[f"{name}_{key}_us"]) for key in ("median", "p99", "worst"))


def delays(row):
    """The age of a level as it arrives, and the echo beside it; nothing in results of before they were measured."""
    return [spread(row["monitor"], "age"), spread(row, "echo")] if "echo_median_us" in row else []


def delay_heads(rows):
    return ["age of a level: median / 99 % / worst", "echo"] if delays(rows[0]) else []


def missed(monitor):
    due = monitor["cycles"] + monitor["missed"]
    return f"{monitor['missed']} of {due} ({monitor['missed'] / max(1, due):.2%})"


def services(rows):
    for row in rows:
        ours, empty = row["ours"], row["empty"]
        yield [row["service"], str(row["clients"]), row["connection"], f"{row['request_bytes']} / {row['response_bytes']}",
               number(ours["per_second"]), times(ours), number(empty["per_second"]), times(empty),
               more(ours["median_us"], empty["median_us"]), str(ours["failed"]), str(empty["failed"]),
               time(row["monitor"]["jitter_p99_us"]), missed(row["monitor"]), f"{row['memory_mb']:.0f}"]


def batches(rows):
    for row in rows:
        yield [row["batch"], f"{row['request_bytes'] / 1000:.0f} / {row['response_bytes'] / 1000:.0f}", time(row["round_trip_us"]),
               time(row["round_trip_p99_us"]), time(row["computation_us"]), time(row["empty_us"]),
               more(row["round_trip_us"], row["computation_us"]),
               more(row["round_trip_us"], row["computation_us"] + row["empty_us"])]


def objects(rows):
    for row in rows:
        monitor = row["monitor"]
        yield [number(row["changes_per_second"]), str(row["clients"]), number(row["calls"]["per_second"]), str(row["messages"]),
               spread(row, "to_level"), *delays(row), f"{monitor['rate']:.0f} Hz", missed(monitor),
               " / ".join(time(monitor[f"computation_{key}_us"]) for key in ("median", "p999")), f"{row['memory_mb']:.0f}"]


def monitors(rows):
    for row in rows:
        monitor = row["monitor"]
        yield [row["robot"], f"{monitor['rate']:.0f} Hz", "yes" if row["realtime_priority"] else "no", str(row["clients"]),
               number(row["calls"]["per_second"]), missed(monitor), f"{row['bare_missed']:.2%}",
               " / ".join(time(monitor[f"jitter_{key}_us"]) for key in ("median", "p99", "p999")),
               " / ".join(time(monitor[f"computation_{key}_us"]) for key in ("median", "p999")),
               " / ".join(time(monitor[f"reaction_{key}_us"]) for key in ("median", "p999", "worst")),
               *delays(row), f"{row['memory_mb']:.0f}"]


def tables(result):
    """Returns the head and the lines of each table of TABLES.md by its name."""
    found = {}
    if result["services"]:
        found["services"] = (
            ["service", "clients", "connections", "bytes", "calls/s", "median / 99 % / 99.9 %", "empty: calls/s",
             "median / 99 % / 99.9 %", "over empty", "lost", "empty: lost", "monitor's jitter 99 %", "cycles missed", "MB"],
            services(result["services"]))
    if result["batches"]:
        found["batches"] = (
            ["batch", "kB", "median", "99 %", "computation", "empty service", "over computation", "over both"],
            batches(result["batches"]))
    if result.get("objects"):  # not in results of before there were objects
        found["objects"] = (
            ["other changes/s", "clients", "calls/s", "messages", "message to level: median / 99 % / worst",
             *delay_heads(result["objects"]), "monitor", "cycles missed", "cycle: median / 99.9 %", "MB"],
            objects(result["objects"]))
    if result["monitors"]:
        found["monitors"] = (
            ["monitor", "rate", "real-time", "clients", "calls/s", "cycles missed", "bare thread",
             "jitter: median / 99 % / 99.9 %", "cycle: median / 99.9 %", "reaction: median / 99.9 % / worst",
             *delay_heads(result["monitors"]), "MB"],
            monitors(result["monitors"]))
    return found


def note(result):
    return (f"TF at {result['tf_rate']:.0f} Hz, {result['cores']} cores. empty: a service of as many bytes that does nothing, on\n"
            "the same machine at the same time; jitter: of the time between two cycles; missed: a period without a cycle;\n"
            "bare thread: what one that does nothing misses at that rate and priority, at the same time;\n"
            "reaction: from a transform that just missed a cycle to the level of the next one, in another process;\n"
            "age: from the stamp of the transforms to their level, in another process; echo: a message through a process that\n"
            "only sends it back. What sends transforms and receives levels and echoes is real-time where the system grants it.")
