"""Sweeps on this machine: what they make, restarts, failures, Ctrl-C, locks."""
from __future__ import annotations

import json
import os
import re
import signal
import socket
from pathlib import Path

import pytest

from sweep_tools import (DAMPING, FRICTION, SCENE, call, check_hashes, count_frames, find_states, get_program, make_sweep,
                         read_record, read_table, start, wait_until)

numpy = pytest.importorskip("numpy")

LONG = "frames: 600"  # seconds: long enough to be interrupted
# At the second height the sheet starts in the spike.
HEIGHTS = 'height: {path: "cloth[0].translate", grid: [[0.02, 0.01, 0.16], [0.02, 0.01, 0.05], [0.02, 0.01, 0.2]]}'


@pytest.fixture(name="folder")
def make_folder(tmp_path: Path) -> Path:
    get_program()
    return tmp_path


def test_six_runs_give_table_arrays_and_page(folder: Path) -> None:
    path = make_sweep(folder, more="collect: {positions: [sheet], frames: [0, 6]}")
    said = call(path, "-j", 2)
    out = folder / "out"
    assert "6 of 6 runs whole" in said
    rows = read_table(out)
    assert [(row["friction"], row["damping"]) for row in rows] == [(f, d) for f in ("0.1", "0.2", "0.4") for d in ("0.1", "0.5")]
    assert all(row["state"] == "whole" and row["verdict"] == "clean" and row["exit_code"] == "0" for row in rows)
    assert all(row["frames"] == "7" and float(row["largest_stretch"]) > 1 and float(row["wall_seconds"]) > 0 for row in rows)
    assert len({row["state_hash"] for row in rows}) == 6
    check_hashes(out, folder / "scene.yaml", folder)
    for row in rows:
        name = f"{int(row['run']):04d}"
        with numpy.load(out / "arrays" / f"{name}.npz") as arrays:
            cache = numpy.fromfile(out / "runs" / name / "sheet.pc2", dtype="<f4", offset=32).reshape(7, 144, 3)
            assert numpy.array_equal(arrays["positions_sheet"], cache[[0, 6]])
            assert arrays["frames"].tolist() == [0, 6] and arrays["times"][1] == pytest.approx(0.12)
        assert (out / "pictures" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    page = (out / "index.html").read_text()
    assert page.count("data:image/png;base64,") == 6 and page.count("<tr>") == 7
    assert not re.search(r'(src|href)="(https?:)?//', page) and "@import" not in page
    assert not [p for p in out.rglob("*.tmp*")]


def make_spy(path: Path) -> Path:
    """A program that notes its call in a file beside itself."""
    path.write_text(f'#!/bin/sh\necho "$0 $*" >>"{path}.called"\necho 7\n')
    path.chmod(0o755)
    return path


def test_files_start_no_programs(folder: Path) -> None:
    """Where runs happen, and which program they are, comes from the command line, whatever a sweep file and a folder say."""
    path = make_sweep(folder, FRICTION, more="slurm: {time: 10, mem: 1G}")
    queue = make_spy(folder / "sbatch")
    search = f"{folder}{os.pathsep}{os.environ['PATH']}"
    assert "--engine slurm submits them" in call(path, PATH=search)
    out, called = folder / "out", Path(f"{queue}.called")
    assert not called.exists() and find_states(out) == ["whole"] * 3
    spy = make_spy(folder / "spy")
    for record in (out / "records").glob("*.json"):
        record.write_text(json.dumps(dict(json.loads(record.read_text()), program=str(spy))))
    (out / "sweep.yaml").write_text(re.sub("(?m)^program: .*", f"program: {spy}", (out / "sweep.yaml").read_text()))
    for name in ("0000", "0001"):
        (out / "pictures" / f"{name}.png").unlink()
    assert "3 of 3 runs whole" in call("collect", out)
    call(path)
    assert (out / "pictures" / "0001.png").exists() and not Path(f"{spy}.called").exists()
    # By the command line Slurm is asked, with what it says.
    other = ("-o", folder / "other")
    assert "--sbatch and --setup are for" in call(path, *other, "--setup", "date", code=2)
    assert "is set by the sweep itself" in call(path, *other, "--engine", "slurm", "--sbatch", "array=1", code=2)
    call(path, *other, "--engine", "slurm", "--detach", "--setup", "module load python", "--sbatch", "export=NONE", "--sbatch",
         "mem=2G", PATH=search)
    text = next((folder / "other" / "slurm").glob("*.sbatch")).read_text()
    assert called.read_text().count("sbatch --parsable") == 1
    assert '#SBATCH --time="10"\n' in text and '#SBATCH --mem="2G"\n' in text and '#SBATCH --export="NONE"\n' in text
    assert text.index("\nmodule load python\n") < text.index("\nexec env ") and f" {get_program()} " in text


def test_restart_leaves_alone_what_is_whole(folder: Path) -> None:
    path = make_sweep(folder, FRICTION)
    call(path)
    out = folder / "out"
    times = {p: p.stat().st_mtime_ns for p in (out / "runs").rglob("*")}
    call(path)
    assert times == {p: p.stat().st_mtime_ns for p in (out / "runs").rglob("*")}
    assert [row["attempts"] for row in read_table(out)] == ["1", "1", "1"]
    # A further value is run; the others keep their numbers.
    make_sweep(folder, FRICTION.replace("[0.1, 0.2, 0.4]", "[0.05, 0.1, 0.2, 0.4]"))
    call(path)
    assert {row["friction"]: row["run"] for row in read_table(out)} == {"0.1": "0", "0.2": "1", "0.4": "2", "0.05": "3"}
    assert all(p.stat().st_mtime_ns == then for p, then in times.items() if p.name != "runs" and p.is_file())


def test_a_run_that_was_removed_is_made_again(folder: Path) -> None:
    path = make_sweep(folder, FRICTION)
    call(path)
    out = folder / "out"
    before = read_table(out)
    for one in (out / "runs" / "0001").iterdir():
        one.unlink()
    (out / "runs" / "0001").rmdir()
    assert "1 lost" in call("status", out, code=1)
    call(path)
    assert [row["state_hash"] for row in read_table(out)] == [row["state_hash"] for row in before]
    assert [row["attempts"] for row in read_table(out)] == ["1", "2", "1"]


def test_a_changed_scene_or_value_is_refused_or_replaced(folder: Path) -> None:
    path = make_sweep(folder, FRICTION)
    call(path)
    out = folder / "out"
    old = [row["state_hash"] for row in read_table(out)]
    (folder / "scene.yaml").write_text(SCENE.replace("0.16]", "0.17]"))
    said = call(path, code=2)
    assert "scene.yaml has changed" in said and "--replace" in said
    assert [row["state_hash"] for row in read_table(out)] == old
    call(path, "--replace")
    new = read_table(out)
    assert not set(old) & {row["state_hash"] for row in new} and [row["run"] for row in new] == ["0", "1", "2"]
    check_hashes(out, folder / "scene.yaml", folder)
    # A value that is gone is in the way, too; its run goes with all its files.
    make_sweep(folder, FRICTION.replace("0.2, ", ""), scene=SCENE.replace("0.16]", "0.17]"))
    assert "run 0001 has values that the sweep no longer has: friction 0.2" in call(path, code=2)
    call(path, "--replace")
    assert [row["run"] for row in read_table(out)] == ["0", "2"] and not (out / "runs" / "0001").exists()


def test_a_mesh_that_changes_makes_another_sweep(folder: Path) -> None:
    path = make_sweep(folder, 'mesh: {path: "cloth[0].mesh.file", grid: [a.obj, b.obj]}', scene=SCENE.replace(
        "mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [12, 12]}", "mesh: {file: c.obj}"))
    for name, size in (("a", 0.1), ("b", 0.2), ("c", 0.3)):
        (folder / f"{name}.obj").write_text(f"v 0 0 0\nv {size} 0 0\nv {size} {size} 0\nv 0 {size} 0\nf 1 2 3\nf 1 3 4\n")
    call(path)
    out = folder / "out"
    assert [row["mesh"] for row in read_table(out)] == ["a.obj", "b.obj"]
    assert len({row["state_hash"] for row in read_table(out)}) == 2
    (folder / "b.obj").write_text((folder / "b.obj").read_text().replace("0.2", "0.25"))
    assert "b.obj has changed" in call(path, code=2)
    call(path, "--replace")
    assert read_record(out, 0)["attempts"] == 1 and read_record(out, 1)["attempts"] == 1


def test_an_input_that_changes_meanwhile_stops_the_runs(folder: Path) -> None:
    path = make_sweep(folder, FRICTION, more="frames: 400")
    child = start(path, "-j", 1)
    out = folder / "out"
    wait_until(lambda: count_frames(out, 0) > 2, "the first run")
    (folder / "scene.yaml").write_text(SCENE.replace("0.16]", "0.17]"))
    said = child.communicate(timeout=60)[1]
    assert child.returncode == 1 and "scene.yaml has changed since the sweep was planned" in said
    assert find_states(out)[1:] == ["interrupted", "interrupted"]


def test_a_failing_run_is_told_and_stops_no_other(folder: Path) -> None:
    path = make_sweep(folder, HEIGHTS)
    said = call(path, code=1)
    out = folder / "out"
    assert "run 0001: failed" in said and "triangles intersect at the start" in said and "height [0.02, 0.01, 0.05]" in said
    assert [row["state"] for row in read_table(out)] == ["whole", "failed", "whole"]
    assert read_table(out)[1]["exit_code"] == "2" and "intersect" in read_table(out)[1]["reason"]
    assert 'class="bad">failed' in (out / "index.html").read_text()
    told = call("status", out, code=1)
    assert "2 of 3 runs whole, 1 failed" in told and "intersect at the start" in told
    call(path, code=1)
    assert read_record(out, 1)["attempts"] == 1
    call(path, "--retry-failed", code=1)
    assert [read_record(out, n)["attempts"] for n in range(3)] == [1, 2, 1]


def test_ctrl_c_stops_at_a_checkpoint_and_goes_on(folder: Path) -> None:
    path = make_sweep(folder, FRICTION, more=LONG)
    out = folder / "out"
    child = start(path, "-j", 2)
    wait_until(lambda: count_frames(out, 0) > 3 and count_frames(out, 1) > 3, "two runs")
    child.send_signal(signal.SIGINT)
    child.communicate(timeout=60)
    assert child.returncode == 130
    assert find_states(out) == ["interrupted", "interrupted", "waiting"]
    for name in ("0000", "0001"):
        assert json.loads((out / "runs" / name / "run.json").read_text())["state"] == "interrupted"
        assert (out / "runs" / name / "checkpoint.bin").exists()
    assert "2 interrupted" in call("status", out)
    call(path, "-j", 2)
    assert [row["attempts"] for row in read_table(out)] == ["2", "2", "1"]
    check_hashes(out, folder / "scene.yaml", folder)


def test_killed_at_once_it_goes_on(folder: Path) -> None:
    path = make_sweep(folder, FRICTION, more=LONG)
    out = folder / "out"
    child = start(path, "-j", 1)
    wait_until(lambda: count_frames(out, 0) > 3, "a run")
    os.kill(child.pid, signal.SIGKILL)
    child.communicate()
    assert "1 lost" in call("status", out, code=1)
    # The program that it had started may still write; the run waits for it.
    call(path, "-j", 2)
    check_hashes(out, folder / "scene.yaml", folder)


def test_killed_while_it_was_planned_it_goes_on(folder: Path) -> None:
    path = make_sweep(folder, FRICTION)
    call(path)
    out = folder / "out"
    for name in ("records/0001.json", "inputs.json", "table.csv"):
        (out / name).unlink()
    (out / "records" / ".0002.host.1.2.tmp.json").write_text("{")
    assert "2 of 3 runs whole, 1 waiting" in call("status", out)
    call("collect", out)
    assert [row["state"] for row in read_table(out)] == ["whole", "waiting", "whole"]
    call(path)
    assert [row["state"] for row in read_table(out)] == ["whole"] * 3


def test_two_sweeps_in_a_folder_are_refused(folder: Path) -> None:
    path = make_sweep(folder, FRICTION, more=LONG)
    out = folder / "out"
    child = start(path, "-j", 1)
    try:
        wait_until(lambda: count_frames(out, 0) > 0, "a run")
        assert f"another sweep works here: process {child.pid} on {socket.gethostname()}" in call(path, code=2)
    finally:
        child.send_signal(signal.SIGINT)
        child.communicate(timeout=60)
    (out / "lock").write_text(json.dumps({"host": "elsewhere", "pid": 1}))
    said = call(path, code=2)
    assert "process 1 on elsewhere" in said and f"remove {out}/lock" in said


def test_a_run_that_takes_too_long_is_given_up_and_can_go_on(folder: Path) -> None:
    path = make_sweep(folder, FRICTION.replace("[0.1, 0.2, 0.4]", "[0.1]"), more="frames: 100000\nlimits: {time: 0.7 s}")
    out = folder / "out"
    assert "took longer than limits.time, 0.7 s" in call(path, code=1)
    frames = count_frames(out, 0)
    assert frames > 1
    for _ in range(20):  # on a busy machine 0.7 s may pass before the first new frame
        call(path, "--retry-failed", code=1)
        if count_frames(out, 0) > frames:
            break
    assert count_frames(out, 0) > frames


def test_a_run_that_is_killed_is_tried_again(folder: Path) -> None:
    wrapper = folder / "tulle"
    wrapper.write_text(f"""#!/bin/sh
if [ "$1" = run ] && [ ! -e {folder}/once ]; then touch {folder}/once; kill -9 $$; fi
exec {get_program()} "$@"
""")
    wrapper.chmod(0o755)
    one = FRICTION.replace("[0.1, 0.2, 0.4]", "[0.1]")
    path = make_sweep(folder, one)
    said = call(path, "--program", wrapper, code=1)
    assert "killed by signal 9" in said
    call(path, "--program", wrapper, "--retry-failed")
    (folder / "once").unlink()
    make_sweep(folder, one, more="limits: {retries: 1}")
    call(path, "--program", wrapper, "-o", folder / "other")
    assert (folder / "once").exists() and read_table(folder / "other")[0]["state"] == "whole"


def test_collect_makes_what_is_missing(folder: Path) -> None:
    path = make_sweep(folder, FRICTION)
    call(path)
    out = folder / "out"
    kept = {p: p.read_bytes() for p in (out / "table.csv", out / "arrays" / "0001.npz", out / "pictures" / "0002.png")}
    for p in kept:
        p.unlink()
    call("collect", out)
    assert kept[out / "table.csv"] == (out / "table.csv").read_bytes()
    assert kept[out / "pictures" / "0002.png"] == (out / "pictures" / "0002.png").read_bytes()
    with numpy.load(out / "arrays" / "0001.npz") as arrays:
        assert arrays["positions_sheet"].shape == (1, 144, 3)
    # Other arrays are made of the same runs.
    make_sweep(folder, FRICTION, more="collect: {frames: all}")
    call(path)
    with numpy.load(out / "arrays" / "0001.npz") as arrays:
        assert arrays["positions_sheet"].shape == (7, 144, 3)
    assert read_record(out, 1)["attempts"] == 1
    make_sweep(folder, FRICTION, more="collect: {positions: [shirt]}")
    assert "there is no cloth shirt; the cloths are sheet" in call(path)


def test_a_wrong_path_is_told_with_its_place(folder: Path) -> None:
    path = make_sweep(folder, 'friction: {path: "cloth[0].material.frictoin", grid: [0.1]}')
    said = call(path, code=2)
    assert re.search(r"sweep\.yaml:5:\d+: parameters\.friction\.grid: the program says: --set cloth\[0\]", said)
    assert not (folder / "out" / "sweep.yaml").exists()
    path = make_sweep(folder, FRICTION, scene="gravity: 5\n" + SCENE)
    assert "the scene cannot be run" in call(path, code=2)


def test_usage(folder: Path) -> None:
    path = make_sweep(folder, FRICTION, DAMPING)
    assert "6 runs" in call(path, "--dry-run") and not (folder / "out").exists()
    assert "cannot be read" in call(folder / "none.yaml", code=2)
    # The sweep's own file is called like the resolved one: it is not written over.
    text = path.read_text()
    assert "is no resolved sweep" in call("status", folder, code=2)
    assert "is no resolved sweep" in call(path, "-o", folder, code=2)
    assert path.read_text() == text
    (folder / "other").mkdir()
    (folder / "other" / "mine.txt").write_text("mine")
    assert "holds no sweep" in call(path, "-o", folder / "other", code=2)
    assert "holds no sweep" in call("collect", folder / "other", code=2)
    assert "is no program" in call(path, "--program", "/none", code=2)
    assert "--detach is for" in call(path, "--detach", code=2)
    assert "should be a whole number" in call(path, "-j", "0", code=2)
