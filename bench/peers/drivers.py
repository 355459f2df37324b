"""Starts a tool, watches it, and collects what its driver told."""
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess

import cases
import meshes

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
MODULES = ROOT / "build" / "peers" / "node_modules"
BULLET = ROOT / "build" / "peers" / "bullet_driver"
TICKS = os.sysconf("SC_CLK_TCK")
START_UP = 120  # s of processor time beyond the limit, for start-up and a last frame


class Result:
    def __init__(self, version="", message=""):
        self.version, self.message = version, message
        self.times, self.cpu, self.frames = [0.0], [0.0], []
        self.memory = 0


def get_command(tool, folder):
    """How a tool's driver is started, or why it can not be: (command, None) or (None, reason)."""
    case, output = str(folder / "case.txt"), str(folder)
    if tool == "Blender":
        if not shutil.which("blender"):
            return None, "not installed: blender"
        driver = str(HERE / "blender_driver.py")
        return ["blender", "-b", "--factory-startup", "--threads", "1", "--python-exit-code", "1", "--python", driver, "--", case, output], None
    if tool == "MuJoCo":
        if not shutil.which("node"):
            return None, "not installed: node"
        if not (MODULES / "@mujoco" / "mujoco").exists():
            return None, f"not installed: @mujoco/mujoco in {MODULES.relative_to(ROOT)}"
        return ["node", str(HERE / "mujoco_driver.mjs"), str(MODULES), case, output], None
    if not BULLET.exists():
        return None, f"not built: {BULLET.relative_to(ROOT)}, which needs libbullet-dev and a C++ compiler"
    return [str(BULLET), case, output], None


def write_case(path, physics, run, options, settings):
    lines = [f"cloth {run / 'cloth.obj'}"]
    for mesh in sorted(run.glob("*.obj")):
        if mesh.name != "cloth.obj":
            lines.append(f"obstacle {mesh} {physics.get_friction(mesh):.9g}")
    lines += [f"mass {physics.mass:.9g}", f"gravity {cases.GRAVITY}", f"frames {options.frames}",
              f"interval {cases.INTERVAL:.12g}", f"limit {options.limit:g}"]  # fmt: skip
    for name, value in settings.items():
        lines.append(f"set {name} {value if isinstance(value, str) else format(value, '.9g')}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def parse_told(text):
    """Version, message, times and processor times of told.txt; a last line without an end does not count."""
    result = Result()
    result.times, result.cpu = [], []
    for line in text.split("\n")[:-1]:
        key, _, rest = line.partition(" ")
        if key == "version":
            result.version = rest
        elif key == "message":
            result.message = (result.message + " " + rest).strip()
        elif key == "frame":
            time, cpu = rest.split()
            result.times.append(float(time))
            result.cpu.append(float(cpu))
    return result


def describe_end(status, log):
    """Why a driver ended that did not end well: its signal or code and the last it printed."""
    lines = [line.strip() for line in log.splitlines() if line.strip() and line.strip() != "Blender quit"]
    last = lines[-1][:200] if lines else "without a word"
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        if number == signal.SIGXCPU:
            return "stopped within a frame: the limit of processor time"
        return f"died of {signal.Signals(number).name}: {last}"
    return f"exit code {os.WEXITSTATUS(status)}: {last}" if os.WEXITSTATUS(status) else ""


def run_peer(options, tool, settings, physics, run, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for old in ("told.txt", "frames.raw"):
        (folder / old).unlink(missing_ok=True)
    write_case(folder / "case.txt", physics, run, options, settings)
    command, reason = get_command(tool, folder)
    if command is None:
        return Result(message=f"skipped: {reason}")
    seconds = int(options.limit) + START_UP

    def limit_cpu():
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 10))

    with open(folder / "log", "w", encoding="utf-8") as log:
        process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, preexec_fn=limit_cpu, cwd=folder)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = status
    told = folder / "told.txt"
    result = parse_told(told.read_text(encoding="utf-8")) if told.exists() else Result()
    end = describe_end(status, (folder / "log").read_text(encoding="utf-8", errors="replace"))
    result.message = (result.message + " " + end).strip()
    result.memory = usage.ru_maxrss * 1024
    if (folder / "frames.raw").exists():
        result.frames = meshes.read_frames(folder / "frames.raw", physics.vertex_count)
    count = min(len(result.frames), len(result.times))
    result.frames, result.times, result.cpu = result.frames[:count], result.times[:count] or [0.0], result.cpu[:count] or [0.0]
    return result


def get_cpu(pid):
    """Processor time of a process so far, user and system [s]."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def read_progress(lines, steps_per_frame, get_cpu_now):
    """Times of the frames after the start and the processor time at each, from `tulle run --progress json`."""
    times, cpu = [], []
    for line in lines:
        if not line.startswith("{"):
            continue
        event = json.loads(line)
        if event["event"] == "step" and (event["step"]) % steps_per_frame == 0:
            times.append(event["time"])
            cpu.append(get_cpu_now())
    return times, cpu


def run_tulle(options, scene, folder, frame_rate=None):
    """All that the process takes counts: start-up, the files it writes, checkpoints. frame_rate: of frames that are a step each;
    None: as the scene has it."""
    folder.mkdir(parents=True, exist_ok=True)
    run = folder / "run"
    command = [options.tulle, "run", ROOT / "scenes" / f"{scene}.yaml", "-o", run, "--force", "-t", "1", "--progress", "json"]
    steps_per_frame = 1
    if frame_rate:
        command += ["--set", f"time.step=1/{frame_rate} s", "--set", "time.steps_per_frame=1"]
    else:
        text = (ROOT / "scenes" / f"{scene}.yaml").read_text(encoding="utf-8")
        steps_per_frame = int(re.search(r"steps_per_frame: (\d+)", text).group(1))
        frame_rate = int(re.search(r"step: 1/(\d+) s", text).group(1)) / steps_per_frame
    command += ["-n", str(max(1, round(options.frames * cases.INTERVAL * frame_rate)))]
    version = subprocess.run([options.tulle, "--version"], capture_output=True, text=True, check=True).stdout.split("\n")[0]
    result = Result(version.replace("tulle ", ""))
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    times, cpu = read_progress(process.stderr, steps_per_frame, lambda: get_cpu(process.pid))
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = status
    if status:
        raise RuntimeError(f"tulle run {scene} did not end well: {status}")
    cpu[-1] = usage.ru_utime + usage.ru_stime
    result.times += times
    result.cpu += cpu
    result.memory = usage.ru_maxrss * 1024
    result.frames = meshes.read_frames(run / "cloth.pc2", len(meshes.Mesh(run / "cloth.obj").vertices), skipped=32)
    return result
