"""`report.html`: one page about a run, made from the files of its folder alone, that needs no network.

`charts` and `page` say what it shows, in the template `page.html`; `chart.js` draws, `page.js` moves with the slider.
"""

from crackgrow.results.report.page import write_report

__all__ = ["write_report"]
