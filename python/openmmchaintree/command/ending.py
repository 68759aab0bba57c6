"""The end of a run of the command: its reports and its exit status."""

from .outputs.outputfiles import asJSON
from .reports.noteoutput import asText
from .terminal import BAD_INPUT, BEYOND_LIMIT, ofSignal, printError


def writeReports(writing, outputs, notes, summary, makePage):
    """Write the notes, the summary and the page of a run to the Outputs "notes", "json" and "report", if present.

    makePage : function that returns the page
    """
    if "notes" in outputs:
        writing.write(outputs["notes"], lambda output: output.write(asText(notes)))
    if "json" in outputs:
        writing.write(outputs["json"], lambda output: output.write(asJSON(summary)))
    if "report" in outputs:
        writing.write(outputs["report"], lambda output: output.write(makePage()))


def endRun(writing, isBeyond, interrupts):
    """Report failures of writing; return the exit status.

    isBeyond : whether pairs are beyond their limit, or bonds have changed; interrupts : Interrupts
    """
    if writing.failures:
        printError(writing.describeFailures())
    if isBeyond:
        return BEYOND_LIMIT
    if writing.failures:
        return BAD_INPUT
    return ofSignal(interrupts.number) if interrupts else 0
