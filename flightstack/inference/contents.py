"""Look through a graph's file before it is loaded: it computes what networks compute, and no more.

A graph may also hold loops, branches, functions, and names of other files to read weights from.
None of these is in a network that flies here, and each lets whoever made the file hang or mislead
the program that loads it. ONNX's files are messages of Protocol Buffers (onnx/onnx.proto3).
"""

from collections.abc import Iterator

OPERATORS = frozenset(
    (
        *("Add", "Sub", "Mul", "Div", "Exp", "Tanh", "Relu", "Clip", "Cast", "MatMul", "Gemm"),
        *("Conv", "BatchNormalization", "MaxPool", "Resize", "Constant", "Less", "Softmax"),
        *("Shape", "Reshape", "Expand", "Transpose", "Concat", "Slice", "Squeeze", "Unsqueeze"),
        *("CumSum", "GatherElements", "ReduceSum", "Range", "Mod", "Floor", "LogSoftmax", "Split"),
    )
)
GRAPH, FUNCTIONS = 7, 25  # fields of a model
NODE, INITIALIZER, SPARSE_INITIALIZER = 1, 5, 15  # of a graph
ATTRIBUTE, OPERATOR, DOMAIN = 5, 4, 7  # of a node
TENSOR, TENSORS = 5, 10  # of an attribute
SUBGRAPH, SUBGRAPHS = 6, 11
EXTERNAL_DATA, DATA_LOCATION = 13, 14  # of a tensor
VARINT, BYTES = 0, 2  # how a field is written
FIXED_BYTES = {1: 8, 5: 4}
MAX_VARINT_BYTES = 10


def complaint(content: bytes) -> str | None:
    """Say what a graph holds that no network here does, or that it cannot be read; else None."""
    try:
        return next(_complaints(memoryview(content)), None)
    except (IndexError, ValueError) as error:
        return f"it is no graph of ONNX ({error})"


def _complaints(model: memoryview) -> Iterator[str]:
    for field, value in _fields(model):
        if field == FUNCTIONS:
            yield "it defines functions"
        elif field == GRAPH:
            yield from _of_graph(value)


def _of_graph(graph: memoryview) -> Iterator[str]:
    for field, value in _fields(graph):
        if field == NODE:
            yield from _of_node(value)
        elif field == INITIALIZER:
            yield from _of_tensor(value)
        elif field == SPARSE_INITIALIZER:
            yield "it holds sparse weights"


def _of_node(node: memoryview) -> Iterator[str]:
    for field, value in _fields(node):
        if field == OPERATOR and (name := bytes(value).decode(errors="replace")) not in OPERATORS:
            yield f"it computes {name!r}, which no network here does"
        elif field == DOMAIN and value.nbytes:
            yield f"it computes what {bytes(value).decode(errors='replace')!r} defines"
        elif field == ATTRIBUTE:
            yield from _of_attribute(value)


def _of_attribute(attribute: memoryview) -> Iterator[str]:
    for field, value in _fields(attribute):
        if field in (SUBGRAPH, SUBGRAPHS):
            yield "it has a graph inside"
        elif field in (TENSOR, TENSORS):
            yield from _of_tensor(value)


def _of_tensor(tensor: memoryview) -> Iterator[str]:
    if any(field in (EXTERNAL_DATA, DATA_LOCATION) for field, _ in _fields(tensor)):
        yield "its weights are in another file"


def _fields(message: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Split a message into its fields: number and bytes (of numbers: none)."""
    at, empty = 0, message[:0]
    while at < len(message):
        key, at = _varint(message, at)
        field, way = key >> 3, key & 7
        value = empty
        if way == VARINT:
            _, at = _varint(message, at)
        elif way in FIXED_BYTES:
            at += FIXED_BYTES[way]
        elif way == BYTES:
            size, at = _varint(message, at)
            value = message[at : at + size]
            at += size
        else:
            raise ValueError(f"a field is written in way {way}")
        yield field, value
    if at > len(message):
        raise ValueError("it ends in the middle of a field")


def _varint(message: memoryview, at: int) -> tuple[int, int]:
    """Read a number; returns it, and where the next field is."""
    value = 0
    for shift in range(MAX_VARINT_BYTES):
        byte = message[at]
        at += 1
        value |= (byte & 0x7F) << (7 * shift)
        if byte < 0x80:
            return value, at
    raise ValueError("a number has no end")
