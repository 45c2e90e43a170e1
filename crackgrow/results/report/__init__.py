"""`report.html`: one page about a run, made from the files of its folder alone, that needs no network.

`folder` reads the files; `scene` draws the specimen, `charts` and `step_data` say what the page shows of the steps, and
`page` fills the template `page.html` with that and with what to think of it. `chart.js` draws, `page.js` moves it with
the slider.
"""

from crackgrow.results.report.page import write_report

__all__ = ["write_report"]
