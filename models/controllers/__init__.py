"""The control laws as the FMUs compute them: plain floats in a fixed order, the same bits as the C core."""
