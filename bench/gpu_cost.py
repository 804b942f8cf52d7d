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
FREE = frozenset(  # instructions that launch nothing
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
# Instructions that compute nothing: they only move numbers.
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
    """A card, from its data sheet: clock in hertz, bandwidth in bytes a second, memory in bytes. capability: the major CUDA version."""

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
    def xla_target_config(self) -> str:
        """The card as the text proto from which XLA compiles without one (`target_config`).

        Numbers written out are the same for all cards here.
        """
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
# Seconds from the start of a small kernel to that of the next: the best and the worst case.
LAUNCHES = (2e-6, 3.5e-6)
REACHED = 0.85  # of the bandwidth, by a large kernel
BUSY = 0.42  # of the lanes, by code of whole numbers
FIXED = 1e-6  # seconds of a kernel beside its bytes or operations


@dataclass(frozen=True)
class Instruction:
    """One line of a computation, such as `ROOT %add.1 = f32[8]{0} add(%x, %y), metadata=…`.

    shape: `f32[8]{0}`. op: `add`. rest: the text after the bracket that follows `op`.
    """

    is_root: bool
    name: str
    shape: str
    op: str
    rest: str

    @cached_property
    def operands(self) -> tuple[str, ...]:
        """The names of its operands."""
        in_brackets = re.split(r"\)(?:, |$)", self.rest)[0]
        return tuple(re.findall(r"%([\w.\-]+)", in_brackets))

    @property
    def size(self) -> int:
        """The bytes of its result."""
        return size_of(self.shape)

    @cached_property
    def called(self) -> tuple[str, ...]:
        """The names of the computations that it calls: the body of a loop, the branches."""
        lists = [one or several for one, several in _CALLED.findall(self.rest)]
        return tuple(name.strip().lstrip("%") for list_ in lists for name in list_.split(","))

    @cached_property
    def fused(self) -> str | None:
        """The name of the computation that it is a fusion of; None if it is no fusion."""
        calls = re.search(r"calls=%([\w.\-]+)", self.rest)
        return calls[1] if calls else None


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
        """Returns the time of all its launches, if one takes `launch` seconds at least."""
        operations_per_s = gpu.cores * gpu.lanes_a_core * gpu.clock * BUSY
        moving = self.bytes / (REACHED * gpu.bandwidth) + FIXED
        working = self.operations / operations_per_s + FIXED
        return self.times * max(launch, moving, working)


@dataclass(frozen=True)
class Cost:
    """The cost of a module.

    waits: how often the host waits for a predicate, once for each execution of a loop or branch that depends on data.
    """

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
        shorter, longer = LAUNCHES
        return (
            sum(kernel.seconds(gpu, shorter) for kernel in self.kernels),
            sum(kernel.seconds(gpu, longer) for kernel in self.kernels),
        )


def size_of(shape: str) -> int:
    """Returns the bytes of a shape as HLO writes it: an array, or a tuple of some."""
    return sum(BYTES[dtype] * _product(dims) for dtype, dims in _ARRAY.findall(shape))


def elements_of(shape: str) -> int:
    """Returns how many elements the first array of a shape has."""
    array = _ARRAY.search(shape)
    return _product(array[2]) if array else 1


def _product(dims: str) -> int:
    """Returns the product of `3,4,5`; 1 of an empty text."""
    return math.prod(int(dim) for dim in dims.split(",") if dim)


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
        """Reads the text of a compiled HLO module."""
        self.computations: dict[str, list[Instruction]] = {}
        self.entry = ""
        self.callers = _callers(text)
        current: list[Instruction] = []
        for line in text.splitlines():
            if head := _HEAD.match(line):
                current = self.computations[head[2]] = []
                if head[1]:
                    self.entry = head[2]
            elif parts := _INSTRUCTION.match(line):
                root, name, shape, op, rest = parts.groups()
                current.append(Instruction(bool(root), name, shape, op, rest))
        if not self.entry:
            raise ValueError("this is no HLO module: it has no ENTRY computation")

    def cost(self) -> Cost:
        """Returns the cost of one call of the module."""
        kernels: list[Kernel] = []
        waits = 0
        for instruction, computation, times in self.launched(self.entry, 1):
            if instruction.op in ("while", "conditional"):
                waits += times
                continue
            moved, operations = self._bytes_and_operations(instruction, computation)
            made_by = self._made_by(instruction)
            kernels.append(
                Kernel(
                    name=instruction.name,
                    op=instruction.op,
                    bytes=moved,
                    operations=operations,
                    times=times,
                    shape=instruction.shape,
                    made_by=made_by,
                )
            )
        return Cost(tuple(kernels), waits)

    def launched(self, computation: str, times: int) -> Iterator[tuple[Instruction, str, int]]:
        """Yields what a computation launches if it runs `times` times: instruction, its computation, and how often.

        Loops and branches that depend on data are among them.
        """
        for instruction in self.computations[computation]:
            if instruction.op in ("while", "conditional", "call"):
                trip_count = re.search(r'"known_trip_count":\{"n":"(\d+)"', instruction.rest)
                if instruction.op != "call" and not trip_count:
                    yield instruction, computation, times
                turns = int(trip_count[1]) if trip_count else 1
                for inner in instruction.called:
                    yield from self.launched(inner, times * turns)
            elif instruction.op not in FREE:
                yield instruction, computation, times

    def _made_by(self, instruction: Instruction) -> tuple[str, ...]:
        """Returns the functions from which a kernel's instructions come, each once."""
        instructions = [instruction]
        if instruction.fused is not None:
            instructions = self.computations[instruction.fused]
        callers: dict[str, None] = {}
        for one in instructions:
            frame = re.search(r"stack_frame_id=(\d+)", one.rest)
            caller = self.callers.get(frame[1]) if frame else None
            if caller:
                callers[caller] = None
        return tuple(callers)

    def _bytes_and_operations(self, instruction: Instruction, computation: str) -> tuple[int, int]:
        """Returns those of one launch of an instruction of this computation."""
        by_name = {one.name: one for one in self.computations[computation]}
        operands = [by_name[name] for name in instruction.operands if name in by_name]
        if instruction.fused is None or instruction.op != "fusion":
            products = _multiplications(instruction, operands)
            operations = products or elements_of(instruction.shape)
            return _bytes_of_lone(instruction, operands), operations
        fusion = self.computations[instruction.fused]
        parameters = {int(one.rest.split(")")[0]): one for one in fusion if one.op == "parameter"}
        read = sum(
            _bytes_read(parameters[number], fusion)
            for number in range(len(operands))
            if number in parameters
        )
        return read + _bytes_written(fusion), _operations(fusion)


def _callers(text: str) -> dict[str, str]:
    """Returns, by stack of calls that a module names, its last functions without those of JAX: `scrub > times_in`."""
    tables = {
        name: dict(re.findall(r"^(\d+) (.*)$", body, re.MULTILINE))
        for name, body in re.findall(
            r"^(FileNames|FunctionNames|FileLocations|StackFrames)\n((?:\d+ .*\n)*)",
            text,
            re.MULTILINE,
        )
    }
    callers: dict[str, str] = {}
    for frame, entry in tables.get("StackFrames", {}).items():
        location, parent = re.findall(r"(?:file_location|parent_frame)_id=(\d+)", entry)
        file, function = re.findall(
            r"(?:file_name|function_name)_id=(\d+)", tables["FileLocations"][location]
        )
        outer = callers.get(str(int(parent) - 1), "")  # it's written one too high
        if "site-packages" in tables["FileNames"][file]:
            callers[frame] = outer
            continue
        name = tables["FunctionNames"][function].strip('"').split(".")[-1]
        last_outer = outer.split(" > ")[-3:] if outer else []
        callers[frame] = " > ".join([*last_outer, name])
    return callers


def _bytes_of_lone(instruction: Instruction, operands: list[Instruction]) -> int:
    """Returns the bytes that a kernel of one instruction reads and writes."""
    match instruction.op:
        case "dynamic-slice" | "slice":
            return instruction.size + instruction.size
        case "gather":
            return instruction.size + _bytes_looked_up(instruction)
        case "dynamic-update-slice":
            new = operands[1].size
            return new + new
        case _:
            return instruction.size + sum(operand.size for operand in operands)


def _bytes_read(parameter: Instruction, fusion: list[Instruction]) -> int:
    """Returns how much of an operand a fusion reads."""
    total = 0
    names = [parameter.name]  # of the operand, and of bitcasts of it
    while names:
        name = names.pop()
        for user in fusion:
            if name not in user.operands:
                continue
            is_only_first = user.operands[0] == name and name not in user.operands[1:]
            if user.op == "bitcast":
                names.append(user.name)
            elif not is_only_first:
                return parameter.size
            elif user.op in ("dynamic-slice", "slice"):
                total += user.size
            elif user.op == "gather":
                total += _bytes_looked_up(user)
            elif user.op not in ("dynamic-update-slice", "scatter"):  # they change it in place
                return parameter.size
    return min(total, parameter.size)


def _bytes_looked_up(gather: Instruction) -> int:
    """Returns the bytes that a GPU reads for the entries of a gather: a sector each, at least."""
    bytes_an_element = gather.size // max(1, elements_of(gather.shape))
    sizes = re.search(r"slice_sizes=\{([\d,]*)\}", gather.rest)
    entry = bytes_an_element * (_product(sizes[1]) if sizes else 1)
    entries = gather.size // max(1, entry)
    return max(gather.size, entries * SECTOR)


def _results(fusion: list[Instruction]) -> tuple[str, ...]:
    """Returns the names of a fusion's results."""
    root = next(one for one in fusion if one.is_root)
    return root.operands if root.op == "tuple" else (root.name,)


def _bytes_written(fusion: list[Instruction]) -> int:
    """Returns how much a fusion writes."""
    by_name = {one.name: one for one in fusion}
    total = 0
    for name in _results(fusion):
        result = by_name[name]
        while result.op == "bitcast" and result.operands[0] in by_name:
            result = by_name[result.operands[0]]
        if result.op == "dynamic-update-slice":
            total += by_name[result.operands[1]].size
        elif result.op == "scatter":
            total += by_name[result.operands[-1]].size
        else:
            total += by_name[name].size
    return total


def _operations(fusion: list[Instruction]) -> int:
    """Returns a rough count of a fusion's operations: each instruction once for each element that its users ask for."""
    by_name = {one.name: one for one in fusion}
    asked = {name: elements_of(by_name[name].shape) for name in _results(fusion)}
    total = 0
    for one in reversed(fusion):
        if one.name not in asked:
            continue
        operands = [by_name[name] for name in one.operands if name in by_name]
        elements = max(1, elements_of(one.shape))
        reduced = 1  # elements of the operand for each of the result
        if one.op == "reduce" and operands:
            reduced = max(1, elements_of(operands[0].shape) // elements)
        operations = reduced
        if one.op in ("dot", "convolution"):
            operations = max(1, _multiplications(one, operands) // elements)
        if one.op not in NO_OPERATION:
            total += asked[one.name] * operations
        for operand in operands:
            share = asked[one.name] * reduced
            if one.op == "concatenate":
                share = asked[one.name] * elements_of(operand.shape) // elements
            asked[operand.name] = max(asked.get(operand.name, 0), share)
    return total


def _multiplications(one: Instruction, operands: list[Instruction]) -> int:
    """Returns the multiplications of a product of matrices or a convolution; 0 for anything else."""
    # A number of a product needs as many as the axis that is summed is long.
    if one.op == "dot" or (one.op == "custom-call" and "gemm" in one.rest):
        axis = re.search(r"lhs_contracting_dim(?:ension)?s\"?[=:][\[{]\"?(\d+)", one.rest)
        if axis and operands and (left := _ARRAY.search(operands[0].shape)):
            return elements_of(one.shape) * int(left[2].split(",")[int(axis[1])])
    labels = re.search(r"dim_labels=\w+_(\w+)->", one.rest)
    if not labels or len(operands) < 2:
        return 0
    # A number that a convolution makes needs one for each weight of its output channel.
    call = next((name for name in _CONVOLUTIONS if name in one.rest), "")
    activations, weights = _CONVOLUTIONS[call]
    shapes = (operands[0].shape, operands[1].shape, one.shape)
    filters = _ARRAY.search(shapes[weights])
    if filters is None:
        return 0
    output_channels = int(filters[2].split(",")[labels[1].index("o")])
    return elements_of(shapes[activations]) * elements_of(shapes[weights]) // output_channels


# Which of (first operand, second operand, result) are the activations that a convolution makes and its weights, by the name of the call.
_CONVOLUTIONS = {"convBackwardInput": (0, 1), "convBackwardFilter": (1, 2), "": (2, 1)}
