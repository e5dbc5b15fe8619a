# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts a browser and a server of the page's files, and has Blender export what the pages read."""

import functools
import http.server
import queue
import shutil
import threading

import pytest

from tests.games202.probes import PAGE

BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="module")
def browser():
    """The command that opens an address without a window."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if not found:
        pytest.skip("No Chromium is installed (apt-get install chromium)")
    return [found, "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


@pytest.fixture
def served(tmp_path):
    """A folder with the page in it, its address on this machine, and a queue of what is posted there."""
    for path in PAGE.iterdir():
        shutil.copy(path, tmp_path)
    posted: queue.Queue[str] = queue.Queue()

    class Server(http.server.SimpleHTTPRequestHandler):
        """Serves files, keeps what is posted, and writes no log."""

        def do_POST(self):
            """Keep the body."""
            posted.put(self.rfile.read(int(self.headers["Content-Length"])).decode())
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_arguments):
            """Nothing."""

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Server, directory=tmp_path))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield tmp_path, f"http://127.0.0.1:{server.server_port}", posted
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture
def exported(blender, scene, stage, served):
    """Bakes and exports a mesh of one colour that a function of bmesh makes, beside the page, once per mode: its folder."""

    def export(build, colour=(1.0, 1.0, 1.0), **folders):
        stage.environment(stage.picture("Six", stage.six_coloured_sky(32)), strength=0.25)
        mesh = stage.from_bmesh("Figure", build, smooth=False)
        paint = mesh.color_attributes.new("Color", "FLOAT_COLOR", "POINT")
        paint.data.foreach_set("color", (*colour, 1.0) * len(mesh.vertices))
        mesh.color_attributes.active_color = paint
        ob = stage.object_of("Figure", mesh, stage.diffuse(colour=colour))
        ob.select_set(True)
        blender.context.view_layer.objects.active = ob
        blender.ops.wm.obj_export(
            filepath=str(served[0] / "figure.obj"), export_materials=False, export_uv=False, export_colors=True
        )
        for mode, folder in folders.items():
            (served[0] / folder).mkdir(exist_ok=True)
            blender.ops.prt.bake(mode=mode, samples=256, bounces=1)
            blender.ops.prt.export_games202(directory=str(served[0] / folder))
        return served[0]

    return export
