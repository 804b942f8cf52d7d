"""What an optimised HLO module costs on a GPU: kernels launched, bytes moved, operations, and a time by a roofline.

A module is read as text. A kernel is an instruction of the entry, or of a loop or branch below it, that launches something: a fusion, a
copy, a scatter, a sort, a call of a library. A loop whose number of turns XLA knows counts as often as it turns. One whose end depends on
data, or a branch, counts once: its predicate goes to the host, which waits for it in each turn.

Bytes: what a kernel reads of its operands and writes of its results, each byte once. Of an operand that is only sliced the slices count, of
one that is looked up the entries (32 bytes each at least: what a GPU reads at once), and of a result that is an operand with new values in
some places, those values. Of a kernel that Triton compiles, such as one of Pallas, whole operands and results count; its operations aren't in
the text, so one is counted for each number of its result.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

BYTES = {
    "pred": 1,
    "s8": 1,
    "u8": 1,
    "s16": 2,
    "u16": 2,
    "bf16": 2,
    "f16": 2,
    "s32": 4,
    "u32": 4,
    "f32": 4,
    "s64": 8,
    "u64": 8,
    "f64": 8,
}
FREE = frozenset(
    {
        "parameter",
        "constant",
        "tuple",
        "get-tuple-element",
        "bitcast",
        "after-all",
        "partition-id",
        "replica-id",
    }
)
NO_OPERATION = FREE | {"broadcast", "reshape", "transpose", "slice", "iota", "concatenate", "copy"}
SECTOR = 32  # bytes that a GPU reads at once
_ARRAY = re.compile(rf"\b({'|'.join(BYTES)})\[([\d,]*)\]")
_HEAD = re.compile(r"^(ENTRY )?%?([\w.\-]+) \(.*\) -> .* \{")
_INSTRUCTION = re.compile(r"^\s+(ROOT )?%([\w.\-]+) = (\(.*?\)|\S+) ([\w\-]+)\((.*)$")
_CALLED = re.compile(
    r"(?:body|to_apply|condition|true_computation|false_computation)=%?([\w.\-]+)|branch_computations=\{([^}]*)\}"
)


@dataclass(frozen=True)
class Gpu:
    """A card. `description`: what XLA calls its target; the others are a line of its data sheet each, in bytes a second and hertz."""

    name: str
    cores: int
    lanes_a_core: int
    clock: float
    bandwidth: float
    l2: int
    shared_memory_a_core: int
    shared_memory_a_block: int
    capability: int

    @property
    def description(self) -> str:
        return f"""
gpu_device_info {{ threads_per_block_limit: 1024 threads_per_warp: 32 shared_memory_per_block: 49152
  shared_memory_per_core: {self.shared_memory_a_core} threads_per_core_limit: 2048 core_count: {self.cores} fpus_per_core: {self.lanes_a_core}
  block_dim_limit_x: 2147483647 block_dim_limit_y: 65535 block_dim_limit_z: 65535 memory_bandwidth: {self.bandwidth:.0f}
  l2_cache_size: {self.l2} clock_rate_ghz: {self.clock / 1e9} device_memory_size: 84929347584
  shared_memory_per_block_optin: {self.shared_memory_a_block} cuda_compute_capability {{ major: {self.capability} }}
  registers_per_core_limit: 65536 registers_per_block_limit: 65536 }}
platform_name: "CUDA" dnn_version_info {{ major: 9 minor: 8 }} runtime_version {{ major: 12 minor: 9 patch: 0 }}
device_description_str: "{self.name}"
"""


GPUS = {  # NVIDIA's data sheets of the A100 (SXM, 40 GB) and the H100 (SXM)
    "a100": Gpu("NVIDIA A100-SXM4-40GB", 108, 64, 1.41e9, 1555e9, 41943040, 167936, 166912, 8),
    "h100": Gpu("NVIDIA H100 80GB HBM3", 132, 128, 1.98e9, 3352e9, 52428800, 233472, 232448, 9),
}
LAUNCHES = (
    2e-6,
    3.5e-6,
)  # seconds from the start of a kernel to that of the next, of small ones: the best and the worst case
REACHED = 0.85  # of the bandwidth, by a large kernel
BUSY = 0.42  # of the lanes, by code of whole numbers
FIXED = 1e-6  # seconds of a kernel beside its bytes or operations


@dataclass(frozen=True)
class Instruction:
    """One line of a computation. `rest`: what stands after the opening bracket."""

    is_root: bool
    name: str
    shape: str
    op: str
    rest: str

    @cached_property
    def operands(self) -> tuple[str, ...]:
        return tuple(re.findall(r"%([\w.\-]+)", re.split(r"\)(?:, |$)", self.rest)[0]))

    @property
    def size(self) -> int:
        return size_of(self.shape)

    @cached_property
    def called(self) -> tuple[str, ...]:
        found = [one or several for one, several in _CALLED.findall(self.rest)]
        return tuple(name.strip().lstrip("%") for group in found for name in group.split(","))


@dataclass(frozen=True)
class Kernel:
    """What is launched, `times` in all: bytes and operations of one launch. made_by: the functions that its instructions come from."""

    name: str
    op: str
    bytes: int
    operations: int
    times: int
    shape: str = ""
    made_by: tuple[str, ...] = ()

    def seconds(self, gpu: Gpu, launch: float) -> float:
        moving = self.bytes / (REACHED * gpu.bandwidth) + FIXED
        working = self.operations / (gpu.cores * gpu.lanes_a_core * gpu.clock * BUSY) + FIXED
        return self.times * max(launch, moving, working)


@dataclass(frozen=True)
class Cost:
    """`waits`: how often the host waits for a predicate, once for each execution of a loop or branch that depends on data."""

    kernels: tuple[Kernel, ...]
    waits: int

    @property
    def launches(self) -> int:
        return sum(kernel.times for kernel in self.kernels)

    @property
    def bytes(self) -> int:
        return sum(kernel.times * kernel.bytes for kernel in self.kernels)

    @property
    def operations(self) -> int:
        return sum(kernel.times * kernel.operations for kernel in self.kernels)

    def seconds(self, gpu: Gpu) -> tuple[float, float]:
        """Returns the estimate with the shorter and with the longer time of a launch."""
        shorter, longer = (
            sum(kernel.seconds(gpu, launch) for kernel in self.kernels) for launch in LAUNCHES
        )
        return shorter, longer


def size_of(shape: str) -> int:
    """Returns the bytes of a shape as HLO writes it: an array, or a tuple of some."""
    return sum(BYTES[dtype] * _product(dims) for dtype, dims in _ARRAY.findall(shape))


def elements_of(shape: str) -> int:
    """Returns how many elements the first array of a shape has."""
    found = _ARRAY.search(shape)
    return _product(found[2]) if found else 1


def _product(dims: str) -> int:
    return math.prod(int(d) for d in dims.split(",") if d)


def cost_of(text: str) -> Cost:
    """Returns what a module costs. Raises ValueError for a text that is not a module."""
    return _Module(text).cost()


def count_kernels(text: str) -> int:
    """Returns how many kernels a module launches if each loop turns once. Raises ValueError for a text that is not a module."""
    module = _Module(text)
    return sum(
        instruction.op not in ("while", "conditional")
        for instruction, _, _ in module.launched(module.entry, 1)
    )


class _Module:
    def __init__(self, text: str) -> None:
        self.computations: dict[str, list[Instruction]] = {}
        self.entry = ""
        self.callers = _callers(text)
        current: list[Instruction] = []
        for line in text.splitlines():
            if head := _HEAD.match(line):
                current = self.computations[head[2]] = []
                self.entry = head[2] if head[1] else self.entry
            elif found := _INSTRUCTION.match(line):
                current.append(Instruction(bool(found[1]), *found.groups()[1:]))
        if not self.entry:
            raise ValueError("this is no HLO module: it has no ENTRY computation")

    def cost(self) -> Cost:
        kernels: list[Kernel] = []
        waits = 0
        for instruction, computation, times in self.launched(self.entry, 1):
            if instruction.op in ("while", "conditional"):
                waits += times
            else:
                origin = (instruction.shape, self._made_by(instruction))
                kernels.append(
                    Kernel(
                        instruction.name,
                        instruction.op,
                        *self._kernel(instruction, computation),
                        times,
                        *origin,
                    )
                )
        return Cost(tuple(kernels), waits)

    def launched(self, computation: str, times: int) -> Iterator[tuple[Instruction, str, int]]:
        """Yields what is launched, and the loops and branches that depend on data, each with how often that happens."""
        for instruction in self.computations[computation]:
            if instruction.op in ("while", "conditional", "call"):
                known = re.search(r'"known_trip_count":\{"n":"(\d+)"', instruction.rest)
                if instruction.op != "call" and not known:
                    yield instruction, computation, times
                for inner in instruction.called:
                    yield from self.launched(inner, times * (int(known[1]) if known else 1))
            elif instruction.op not in FREE:
                yield instruction, computation, times

    def _made_by(self, instruction: Instruction) -> tuple[str, ...]:
        fused = re.search(r"calls=%([\w.\-]+)", instruction.rest)
        inside = self.computations[fused[1]] if fused else [instruction]
        frames = [
            frame[1] for one in inside if (frame := re.search(r"stack_frame_id=(\d+)", one.rest))
        ]
        return tuple(
            dict.fromkeys(self.callers[frame] for frame in frames if self.callers.get(frame))
        )

    def _kernel(self, instruction: Instruction, computation: str) -> tuple[int, int]:
        """Returns the bytes and operations of one launch."""
        shapes = {one.name: one for one in self.computations[computation]}
        operands = [shapes[name] for name in instruction.operands if name in shapes]
        fused = re.search(r"calls=%([\w.\-]+)", instruction.rest)
        if fused is None or instruction.op != "fusion":
            return _alone(instruction, operands), _multiplications(
                instruction, operands
            ) or elements_of(instruction.shape)
        inside = self.computations[fused[1]]
        parameters = {int(one.rest.split(")")[0]): one for one in inside if one.op == "parameter"}
        read = sum(
            _read(parameters[number], inside)
            for number in range(len(operands))
            if number in parameters
        )
        return read + _written(inside), _operations(inside)


def _callers(text: str) -> dict[str, str]:
    """Returns the last functions of each stack of calls that a module names, such as `scrub > times_in`, without those of JAX."""
    tables = {
        name: dict(re.findall(r"^(\d+) (.*)$", body, re.MULTILINE))
        for name, body in re.findall(
            r"^(FileNames|FunctionNames|FileLocations|StackFrames)\n((?:\d+ .*\n)*)",
            text,
            re.MULTILINE,
        )
    }
    callers: dict[str, str] = {}
    for frame, said in tables.get("StackFrames", {}).items():
        place, parent = re.findall(r"(?:file_location|parent_frame)_id=(\d+)", said)
        file, function = re.findall(
            r"(?:file_name|function_name)_id=(\d+)", tables["FileLocations"][place]
        )
        before = callers.get(str(int(parent) - 1), "")  # it's written one too high
        ours = "site-packages" not in tables["FileNames"][file]
        name = tables["FunctionNames"][function].strip('"').split(".")[-1]
        callers[frame] = (
            " > ".join([*before.split(" > ")[-3:], name] if before else [name]) if ours else before
        )
    return callers


def _alone(instruction: Instruction, operands: list[Instruction]) -> int:
    """Returns the bytes of a kernel that is one instruction."""
    match instruction.op:
        case "dynamic-slice" | "slice" | "gather":
            return 2 * instruction.size
        case "dynamic-update-slice":
            return 2 * operands[1].size
        case _:
            return instruction.size + sum(operand.size for operand in operands)


def _read(parameter: Instruction, inside: list[Instruction]) -> int:
    """Returns how much of an operand a fusion reads."""
    total, waiting = 0, [parameter.name]
    while waiting:
        name = waiting.pop()
        for user in (one for one in inside if name in one.operands):
            first = user.operands[0] == name and name not in user.operands[1:]
            if user.op == "bitcast":
                waiting.append(user.name)
            elif first and user.op in ("dynamic-slice", "slice"):
                total += user.size
            elif first and user.op == "gather":
                sizes = re.search(r"slice_sizes=\{([\d,]*)\}", user.rest)
                entry = (
                    user.size
                    // max(1, elements_of(user.shape))
                    * (_product(sizes[1]) if sizes else 1)
                )
                total += max(user.size, user.size // max(1, entry) * SECTOR)
            elif first and user.op in ("dynamic-update-slice", "scatter"):
                total += 0  # it is changed in place
            else:
                return parameter.size
    return min(total, parameter.size)


def _written(inside: list[Instruction]) -> int:
    """Returns how much a fusion writes."""
    by_name = {one.name: one for one in inside}
    root = next(one for one in inside if one.is_root)
    total = 0
    for name in root.operands if root.op == "tuple" else (root.name,):
        made = by_name[name]
        while made.op == "bitcast" and made.operands[0] in by_name:
            made = by_name[made.operands[0]]
        if made.op == "dynamic-update-slice":
            total += by_name[made.operands[1]].size
        elif made.op == "scatter":
            total += by_name[made.operands[-1]].size
        else:
            total += by_name[name].size
    return total


def _operations(inside: list[Instruction]) -> int:
    """Returns a rough count of a fusion's operations: each instruction once for each element that its users ask for."""
    by_name = {one.name: one for one in inside}
    root = next(one for one in inside if one.is_root)
    asked = {
        name: elements_of(by_name[name].shape)
        for name in (root.operands if root.op == "tuple" else (root.name,))
    }
    total = 0
    for one in reversed(inside):
        if one.name not in asked:
            continue
        operands = [by_name[name] for name in one.operands if name in by_name]
        own = max(1, elements_of(one.shape))
        each = (
            max(1, elements_of(operands[0].shape) // own) if one.op == "reduce" and operands else 1
        )
        times = _multiplications(one, operands) // own if one.op in ("dot", "convolution") else each
        total += 0 if one.op in NO_OPERATION else asked[one.name] * max(1, times)
        for operand in operands:
            share = (
                asked[one.name] * elements_of(operand.shape) // own
                if one.op == "concatenate"
                else asked[one.name] * each
            )
            asked[operand.name] = max(asked.get(operand.name, 0), share)
    return total


def _multiplications(one: Instruction, operands: list[Instruction]) -> int:
    """Returns how many products of numbers a product of matrices or a convolution adds up; 0 of anything else."""
    own = elements_of(one.shape)
    if one.op == "dot" or (one.op == "custom-call" and "gemm" in one.rest):
        dims = re.search(r"lhs_contracting_dim(?:ension)?s\"?[=:][\[{]\"?(\d+)", one.rest)
        if dims and operands and (array := _ARRAY.search(operands[0].shape)):
            return own * int(array[2].split(",")[int(dims[1])])
    labels = re.search(r"dim_labels=\w+_(\w+)->", one.rest)
    if labels and len(operands) > 1:
        made, weights = _CONVOLUTIONS[
            next((name for name in _CONVOLUTIONS if name in one.rest), "")
        ]
        arrays = [*(operand.shape for operand in operands[:2]), one.shape]
        filters = _ARRAY.search(arrays[weights])
        return (
            elements_of(arrays[made])
            * elements_of(arrays[weights])
            // int(filters[2].split(",")[labels[1].index("o")])
            if filters
            else 0
        )
    return 0


# Which of (first operand, second operand, result) are the activations that a convolution makes and its weights, by the name of the call.
_CONVOLUTIONS = {"convBackwardInput": (0, 1), "convBackwardFilter": (1, 2), "": (2, 1)}
