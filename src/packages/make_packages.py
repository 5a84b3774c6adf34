#!/usr/bin/env python3
"""Makes the Debian packages of a build, for `./dev package`.

usage: make_packages.py BUILD_DIR

Each package depends on the packages of the shared libraries that its programs are linked with, as dpkg-shlibdeps finds them,
and on those that package.xml lists.
"""

import gzip
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
# {component: name of its package}
PACKAGES = dict(re.findall(r"(?m)^proximity_package\((\w+) (\S+)", pathlib.Path(__file__).with_name("packages.cmake").read_text()))
ABOUT = {"clearance": "how close a robot is to itself in many states", "explain": "one query of GJK and EPA, step by step",
         "model_check": "what is wrong with a robot's URDF and SRDF",
         "pair_audit": "which pairs of a robot's links can collide",
         "prove": "which pairs of a robot's links and objects stay apart, with proof"}


def run(*command, **options):
    return subprocess.run([str(word) for word in command], check=True, text=True, **options)


def write_manual(build, folder):
    """A page for each tool, of what its --help and --version say."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for tool, about in ABOUT.items():
        program = build / "devel/lib/proximity_server" / tool
        page = run("help2man", "--no-info", "--name", about, program, capture_output=True).stdout
        (folder / f"proximity_server-{tool}.1.gz").write_bytes(gzip.compress(page.encode(), mtime=0))


def listed(elements, marks, pattern):
    """The packages that package.xml lists in these elements behind one of the marks, with a name that has the pattern."""
    text = (SOURCE / "package.xml").read_text().partition("<!-- test, benchmark")[0]
    rows = re.findall(rf"<(?:{elements})>[\w-]+</\w+> *<!-- (?:{marks}) ([^:]*):", text)
    return [name for names in rows for name in names.split() if re.search(pattern, name)]


def shared_libraries(stages, component):
    """The packages of the shared libraries that the programs of a component need, with their versions."""
    files = [path for path in stages[component].rglob("*") if path.is_file() and path.read_bytes()[:4] == b"\x7fELF"]
    if not files:
        return []
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "debian").mkdir()
        (pathlib.Path(folder) / "debian/control").write_text("Source: proximity-server\n\nPackage: any\nArchitecture: any\n")
        found = run("dpkg-shlibdeps", "-O", "--ignore-missing-info", f"-l{stages['library']}/usr/lib", *files, cwd=folder,
                    stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    return re.sub(r".*:Depends=", "", found.strip()).split(", ")


def dependencies(stages):
    """{component: "package, package (>= version), ..."}"""
    version = re.search("<version>(.*)</version>", (SOURCE / "package.xml").read_text())[1]
    ours = {component: f"{name} (= {version})" for component, name in PACKAGES.items()}
    return {name: ", ".join(sorted(set(packages))) for name, packages in {
        "library": shared_libraries(stages, "library"),
        "development": [ours["library"], ours["messages"], *listed("depend", "apt", "-dev$")],
        "messages": listed("depend|exec_depend", "apt|apt-test", "(std|geometry|sensor|shape|trajectory)-msgs|message-runtime|genpy"),
        "node": [ours["library"], ours["messages"], *shared_libraries(stages, "node"),
                 *listed("depend|exec_depend", "apt|apt-test", "^(python3-|ros)")],
        "python": [ours["library"], "python3-numpy", *shared_libraries(stages, "python")],
    }.items()}


def main(build):
    write_manual(build, build / "packages/man")
    with tempfile.TemporaryDirectory() as folder:
        stages = {component: pathlib.Path(folder, component) for component in PACKAGES}
        for component, stage in stages.items():
            run("cmake", "--install", build, "--prefix", "/usr", "--component", component, env={**os.environ, "DESTDIR": str(stage)},
                stdout=subprocess.DEVNULL)
        for old in (build / "packages").glob("*.deb"):
            old.unlink()
        (build / "packages/dependencies.cmake").write_text("".join(
            f'set(CPACK_DEBIAN_{component.upper()}_PACKAGE_DEPENDS "{packages}")\n'
            for component, packages in dependencies(stages).items()))
        run("cpack", cwd=build, stdout=subprocess.DEVNULL)
    shutil.rmtree(build / "packages/_CPack_Packages")  # roslaunch would find a second demo.launch in it
    for package in sorted((build / "packages").glob("*.deb")):
        print(package)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]).resolve())
