"""Compute with message fields: "degrees(ATTITUDE.roll) > 20 and HEARTBEAT.base_mode & 128".

The language is Python's expressions over the latest value of every message, as in mavlogdump's
conditions, but of the vehicle, where it sends that message; it is walked as a tree and computed on
whole columns, never handed to eval.
"""

import ast
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.senders import Participant, of_vehicle
from flightstack.logs.dialect.message_types import message_id
from flightstack.logs.errors import ExpressionError, UnknownNameError

Rows = NDArray[np.intp]
Value = Any  # a column, or a plain number or text

BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
}
COMPARED: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": np.abs,
    "sqrt": np.sqrt,
    "hypot": np.hypot,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "atan2": np.arctan2,
    "degrees": np.degrees,
    "radians": np.radians,
    "exp": np.exp,
    "log": np.log,
    "log10": np.log10,
    "floor": np.floor,
    "ceil": np.ceil,
    "round": np.round,
    "isnan": np.isnan,
    "min": np.minimum,
    "max": np.maximum,
}
CONSTANTS = {"pi": np.pi, "True": True, "False": False}
SYNTAX = "write for example: ATTITUDE.roll > 0.1 and HEARTBEAT.base_mode & 128"


@dataclass(frozen=True, slots=True)
class Expression:
    """A parsed expression: its text, its tree, and the messages that it reads."""

    text: str
    tree: ast.expr
    messages: tuple[str, ...]


def _message_and_field(node: ast.expr) -> tuple[str, str] | None:
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return node.value.id, node.attr
    return None


def parse(text: str, id_of: Callable[[str], int] = message_id) -> Expression:
    """Return the parsed expression; ExpressionError or UnknownNameError say what is wrong.

    `id_of` knows the names of messages: those of the dialect, or a log's own, too.
    """
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ExpressionError(f"{text!r} does not parse ({error}): {SYNTAX}") from error
    pairs = [
        pair
        for node in ast.walk(tree)
        if isinstance(node, ast.expr)
        if (pair := _message_and_field(node))
    ]
    for message, _ in pairs:
        id_of(message)
    return Expression(text, tree, tuple(dict.fromkeys(message for message, _ in pairs)))


class _Evaluator:
    """Walks an expression's tree for the packets `rows` of a log."""

    def __init__(self, log: Log, rows: Rows, text: str, vehicle: Participant | None) -> None:
        self.log = log
        self.vehicle = vehicle  # whose messages are read, where it sends them
        self.rows = rows
        self.text = text
        self.known = np.ones(len(rows), dtype=np.bool_)  # all messages read so far were seen

    def wrong(self, what: str) -> ExpressionError:
        return ExpressionError(f"{self.text!r}: {what}; {SYNTAX}")

    def value(self, node: ast.expr) -> Value:
        """Return the value of a node, a column or a constant."""
        handler = HANDLERS.get(type(node))
        if handler is None:
            raise self.not_allowed(node)
        return handler(self, node)

    def not_allowed(self, node: ast.expr) -> ExpressionError:
        return self.wrong(f"{ast.unparse(node)!r} is not allowed here")

    def constant(self, node: ast.Constant) -> Value:
        if not isinstance(node.value, int | float | str):
            raise self.not_allowed(node)
        return node.value

    def name(self, node: ast.Name) -> Value:
        if node.id not in CONSTANTS:
            raise self.wrong(f"{node.id!r} is not MESSAGE.field")
        return CONSTANTS[node.id]

    def binary(self, node: ast.BinOp) -> Value:
        if type(node.op) not in BINARY:
            raise self.not_allowed(node)
        return BINARY[type(node.op)](self.value(node.left), self.value(node.right))

    def boolean(self, node: ast.BoolOp) -> Value:
        parts = [np.asarray(self.value(value), dtype=np.bool_) for value in node.values]
        combine = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
        return combine.reduce(np.broadcast_arrays(*parts))

    def unary(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        match node.op:
            case ast.Not():
                return np.logical_not(value)
            case ast.USub():
                return operator.neg(value)
            case ast.Invert():
                return operator.invert(value)
        return value

    def compare(self, node: ast.Compare) -> Value:
        values = [self.value(each) for each in (node.left, *node.comparators)]
        parts = []
        for op, left, right in zip(node.ops, values, values[1:], strict=False):
            if type(op) not in COMPARED:
                raise self.not_allowed(node)
            parts.append(COMPARED[type(op)](left, right))
        return np.logical_and.reduce(np.broadcast_arrays(*parts))

    def call(self, node: ast.Call) -> Value:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name not in FUNCTIONS or node.keywords:
            known = ", ".join(sorted(FUNCTIONS))
            raise self.wrong(f"no function {ast.unparse(node.func)!r}; there are {known}")
        return FUNCTIONS[name](*(self.value(argument) for argument in node.args))

    def element(self, node: ast.Subscript) -> Value:
        value = self.value(node.value)
        if not isinstance(node.slice, ast.Constant) or not isinstance(node.slice.value, int):
            raise self.not_allowed(node)
        index = node.slice.value
        if not isinstance(value, np.ndarray) or value.ndim != 2:
            raise self.wrong(f"{ast.unparse(node.value)!r} is not an array field")
        if not -value.shape[1] <= index < value.shape[1]:
            raise self.wrong(f"{ast.unparse(node.value)} has {value.shape[1]} elements")
        return value[:, index]

    def column(self, node: ast.Attribute) -> Value:
        """Return the latest value of a field at each row."""
        pair = _message_and_field(node)
        if pair is None:
            raise self.wrong(f"{ast.unparse(node)!r} is not MESSAGE.field")
        table = of_vehicle(self.log[pair[0]], self.vehicle)
        column = table[pair[1]]
        place = np.searchsorted(table.row, self.rows, side="right") - 1
        self.known &= place >= 0
        if not len(column):
            return np.zeros((len(self.rows), *column.shape[1:]), dtype=column.dtype)
        wide = column.astype(np.float64) if column.dtype.kind == "f" else column
        return wide[np.maximum(place, 0)]


HANDLERS: dict[type[ast.expr], Callable[[_Evaluator, Any], Value]] = {
    ast.Constant: _Evaluator.constant,
    ast.Name: _Evaluator.name,
    ast.Attribute: _Evaluator.column,
    ast.BinOp: _Evaluator.binary,
    ast.UnaryOp: _Evaluator.unary,
    ast.BoolOp: _Evaluator.boolean,
    ast.Compare: _Evaluator.compare,
    ast.Call: _Evaluator.call,
    ast.Subscript: _Evaluator.element,
}


def evaluate(
    expression: Expression, log: Log, rows: Rows, vehicle: Participant | None = None
) -> tuple[Value, NDArray[np.bool_]]:
    """Return the value at each of these packets, and where all its messages had been seen."""
    log.load(expression.messages)
    walker = _Evaluator(log, rows, expression.text, vehicle)
    try:
        with np.errstate(all="ignore"):
            value = walker.value(expression.tree)
    except (TypeError, ValueError, ZeroDivisionError, OverflowError, RecursionError) as error:
        raise walker.wrong(f"cannot be computed ({error})") from error
    except np.exceptions.DTypePromotionError as error:
        raise walker.wrong("compares text with a number") from error
    return value, walker.known


def holds(
    condition: str, log: Log, rows: Rows, vehicle: Participant | None = None
) -> NDArray[np.bool_]:
    """Return at which of these packets a condition holds; not where a message was not yet seen."""
    value, known = evaluate(parse(condition, log.id_of), log, rows, vehicle)
    truth = np.asarray(value)
    if truth.ndim > 1 or truth.dtype.kind not in "biuf":
        raise ExpressionError(f"{condition!r} is no condition: {SYNTAX}")
    return np.broadcast_to(truth.astype(np.bool_), known.shape) & known


def series(
    text: str, log: Log, vehicle: Participant | None = None
) -> tuple[NDArray[np.int64], NDArray[np.float64], str]:
    """Return times, values and unit of a field or expression, at each message that it reads."""
    expression = parse(text, log.id_of)
    if not expression.messages:
        raise ExpressionError(f"{text!r} reads no message; {SYNTAX}")
    log.load(expression.messages)
    present = [message for message in expression.messages if message in log]
    if len(present) < len(expression.messages):
        missing = next(m for m in expression.messages if m not in present)
        raise UnknownNameError(f"{log.name} holds no {missing}; see the command messages")
    read = [of_vehicle(log[message], vehicle) for message in present]
    rows = np.unique(np.concatenate([table.row for table in read]))
    value, known = evaluate(expression, log, rows, vehicle)
    values = np.broadcast_to(np.asarray(value), (len(rows), *np.shape(value)[1:]))[known]
    if values.ndim != 1 or values.dtype.kind not in "biuf":
        hint = "name one element, as in FIELD[0]" if values.ndim > 1 else "it is text"
        raise ExpressionError(f"{text!r} is not a number over time: {hint}")
    pair = _message_and_field(expression.tree)
    unit = log[pair[0]].type.field(pair[1]).unit if pair else ""
    return log.time_us[rows][known], values.astype(np.float64), unit
