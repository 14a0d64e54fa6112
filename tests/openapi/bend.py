"""Bends a light with nothing but the client that is generated from /openapi.json: bend.py URL TOKEN.

Fails with a sentence where the server does not do what the document says.
"""

import sys

from bendylights_client import AuthenticatedClient
from bendylights_client.api.sessions import create_session, edit_session, get_session, render_picture
from bendylights_client.models import (
    Bendy,
    Edit,
    EditResults,
    Edits,
    EditStatus,
    ErrorBody,
    ErrorCode,
    NewSession,
    PointPosition,
    Scope,
    SessionState,
    SetPoint,
)
from bendylights_client.types import File


def expect(what, holds):
    if not holds:
        sys.exit(f"bend.py: {what}")


def main(url, token):
    client = AuthenticatedClient(base_url=url, token=token, raise_on_unexpected_status=True, timeout=120)

    made = create_session.sync(client=client, body=NewSession(name="from-python", scene="demo:vases"))
    expect(f"a session is made, not {made}", isinstance(made, SessionState))
    placed = next(light for light in made.document.lights if isinstance(light.light, Bendy))

    def picture():
        file = render_picture.sync(made.name, client=client, size="160x90")
        expect(f"a picture is a file, not {file}", isinstance(file, File))
        return file.payload.read()

    before = picture()
    expect("a picture is PNG", before.startswith(b"\x89PNG"))

    x, y, z = placed.light.points[-1]
    bend = SetPoint(
        light=placed.id,
        point=len(placed.light.points) - 1,
        parameter=PointPosition(position=[x + 1.5, y, z]),
    )
    answer = edit_session.sync(made.name, client=client, body=Edits(edits=[Edit(command=bend)]))
    expect(f"edits have results, not {answer}", isinstance(answer, EditResults))
    expect(f"the light bends: {answer.results}", answer.results[0].status == EditStatus.COMMITTED)
    expect("the picture changes", picture() != before)

    # Refusals come as types too: one of an edit among its results, one of a request in place of its answer.
    lost = SetPoint(light=placed.id, point=99, parameter=PointPosition(position=[0, 0, 0]))
    edits = [Edit(command=lost), Edit(undo=Scope.SESSION)]
    lost, undone = edit_session.sync(made.name, client=client, body=Edits(edits=edits)).results
    expect(f"there is no control point 99: {lost}", lost.code == ErrorCode.NOTFOUND)
    expect(f"the bend is taken back: {undone}", undone.status == EditStatus.COMMITTED)
    expect("the picture is the first one again", picture() == before)

    taken = create_session.sync(client=client, body=NewSession(name=made.name))
    expect(f"a name is taken once: {taken}", isinstance(taken, ErrorBody) and taken.error.code == ErrorCode.EXISTS)
    nowhere = get_session.sync("nowhere", client=client)
    expect(f"nothing is nowhere: {nowhere}", isinstance(nowhere, ErrorBody))
    expect(f"it says so: {nowhere}", nowhere.error.code == ErrorCode.NOTFOUND and "nowhere" in nowhere.error.message)


main(*sys.argv[1:])
