# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages say in a sentence what is missing, served or opened from disk."""

import re
import subprocess

import pytest

from tests.games202.probes import PAGE, probed

MESSAGE_PROBE = """<!doctype html><iframe id="page"></iframe>
<script>
const page = document.getElementById("page");
page.src = ADDRESS;
const timer = setInterval(() => {
  const said = page.contentDocument?.getElementById("message")?.textContent;
  if (!said || said === "Loading ...") return;
  clearInterval(timer);
  fetch("/found", { method: "POST", body: JSON.stringify(said) });
}, 100);
</script>"""


@pytest.mark.once
def test_page_says_what_is_missing(browser, served):
    """As a sentence, and not on the console."""
    folder, *_ = served

    def said(address):
        return probed(browser, served, MESSAGE_PROBE, ADDRESS=address)

    assert "figure.obj is not there: 404" in said("index.html")
    assert re.search(r"GGX_E(avg)?_LUT.png is not there: 404", said("metal.html"))  # the first that fails
    (folder / "figure.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "transport.txt").write_text("3\n" + "0.28 0 0 0 0 0 0 0 0\n" * 2)
    assert "transport.txt has 2 rows, but the mesh has 3 face corners" in said("index.html?files=.")


@pytest.mark.once
@pytest.mark.parametrize(
    ("page", "sentence"), [("index", "Choose an .obj"), ("reflection", "Choose an .obj"), ("metal", "serve the folder")]
)
def test_page_from_disk_says_what_to_do(browser, page, sentence):
    line = [*browser, "--dump-dom", (PAGE / f"{page}.html").as_uri()]
    done = subprocess.run(line, capture_output=True, text=True, timeout=120, check=True)
    assert sentence in re.search(r'<p id="message">(.*?)</p>', done.stdout, re.DOTALL).group(1)
