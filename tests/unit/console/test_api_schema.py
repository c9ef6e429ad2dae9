"""The API does what its description says, whatever it is asked: schemathesis makes up the requests."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import hypothesis
import pytest
import schemathesis
from schemathesis.checks import not_a_server_error
from schemathesis.core.result import Ok
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from tests.unit.console.served import Served
from turtlewire.console.console import Console
from turtlewire.console.programs import Programs
from turtlewire.console.server import application

if TYPE_CHECKING:
    from collections.abc import Iterator

CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
]
ROBOT = "walter"


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A simulated robot."""
    with Served("sim:walter", folder=tmp_path_factory.mktemp("programs")) as made:
        yield made


@pytest.fixture(scope="module")
def session(served: Served) -> str:
    """Somebody's secret."""
    with served.http() as client:
        secret: str = client.post("/api/sessions").json()["session"]
    return secret


def _description() -> schemathesis.schemas.BaseSchema:
    """What the API says of itself; that takes no robot."""
    with tempfile.TemporaryDirectory() as folder:
        app = application(Console([], lambda _: None, Programs(Path(folder))))
        return schemathesis.openapi.from_dict(app.openapi())


OPERATIONS = {
    result.ok().label: result.ok() for result in _description().get_all_operations() if isinstance(result, Ok)
}


@pytest.mark.parametrize("name", OPERATIONS)
def test_every_answer_is_one_that_was_promised(name: str, served: Served, session: str) -> None:
    headers = {"X-Session": session}

    @hypothesis.settings(
        max_examples=8,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(case=OPERATIONS[name].as_strategy())
    def ask(case: schemathesis.Case[Any]) -> None:
        if "robot" in (case.path_parameters or {}) and len(case.path_parameters["robot"]) % 4:
            case.path_parameters["robot"] = ROBOT
            with served.http(**headers) as client:
                client.post(f"/api/robots/{ROBOT}/wheel", json={"action": "take"})
        case.call_and_validate(base_url=served.address, headers=headers, checks=CHECKS)

    ask()


def test_all_of_it_is_described() -> None:
    assert len(OPERATIONS) > 25
