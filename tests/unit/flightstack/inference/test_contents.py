"""A graph's file is looked through before it is loaded: networks pass, and nothing else."""

from collections.abc import Callable

import onnx
import pytest
from hypothesis import given
from hypothesis import strategies as st
from onnx import TensorProto, helper

from flightstack.inference.contents import complaint
from tests.paths import ROOT

FLYING = sorted((ROOT / "models").glob("*/*/*.onnx"))


def graph_of(*nodes: onnx.NodeProto) -> onnx.ModelProto:
    value = helper.make_tensor_value_info("x", TensorProto.FLOAT, [1])
    return helper.make_model(helper.make_graph(list(nodes), "g", [value], []))


def external() -> onnx.ModelProto:
    model = graph_of()
    tensor = model.graph.initializer.add(name="w", data_type=TensorProto.FLOAT, dims=[4])
    tensor.data_location = TensorProto.EXTERNAL
    tensor.external_data.add(key="location", value="/etc/passwd")
    return model


def external_constant() -> onnx.ModelProto:
    return graph_of(helper.make_node("Constant", [], ["y"], value=external().graph.initializer[0]))


def loop() -> onnx.ModelProto:
    inside = helper.make_graph([], "inside", [], [])
    return graph_of(helper.make_node("Add", ["x"], ["y"], body=inside))


def function() -> onnx.ModelProto:
    model = graph_of()
    model.functions.add(name="f")
    return model


@pytest.mark.parametrize("path", FLYING, ids=lambda path: "-".join(path.parts[-3:]))
def test_every_model_that_comes_along_passes(path: onnx.ModelProto) -> None:
    assert complaint(path.read_bytes()) is None


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: graph_of(helper.make_node("Loop", ["x"], ["y"])), "computes 'Loop'"),
        (lambda: graph_of(helper.make_node("Add", ["x"], ["y"], domain="x.y")), "'x.y' defines"),
        (loop, "a graph inside"),
        (external, "weights are in another file"),
        (external_constant, "weights are in another file"),
        (function, "defines functions"),
    ],
)
def test_what_no_network_holds_is_refused(make: Callable[[], onnx.ModelProto], said: str) -> None:
    assert said in (complaint(make().SerializeToString()) or "")


@given(st.binary(max_size=200))
def test_any_bytes_are_answered(content: bytes) -> None:
    assert complaint(content) is None or isinstance(complaint(content), str)


@given(st.integers(0, 2000), st.integers(0, 255))
def test_a_damaged_graph_is_answered(at: int, byte: int) -> None:
    content = bytearray(external_constant().SerializeToString())
    content[at % len(content)] = byte
    answer = complaint(bytes(content))
    assert answer is None or (answer and "\n" not in answer)


def test_a_graph_that_is_cut_off_is_no_graph() -> None:
    assert "no graph of ONNX" in (complaint(FLYING[0].read_bytes()[:-100]) or "")
