"""Traces with what the plugin sets for the user.

*Only User-Modified Properties*, the default of *Start Trace*, leaves out what no panel has set: the
first handles, and the settings that a display has from that of the input.
"""

import sys

from vtk_mls.paraview.displays import copied_settings

_FIRST_HANDLES = ("RestPoints", "DeformedPoints", "Bounds")
_is_extended = False


def extend(source_names):
    """Add these properties where a trace creates a proxy, from the next trace on.

    `source_names` are the XML names of the proxies with handles.
    """
    global _is_extended
    smtrace = sys.modules.get("paraview.smtrace")  # imported when a trace starts
    if smtrace is None or _is_extended:
        return
    _is_extended = True

    class Accessor(smtrace.RealProxyAccessor):
        def trace_ctor(self, ctor, filter, *arguments, **keywords):
            proxy, usual = self.get_object().SMProxy, filter.should_trace_in_create
            has_handles = proxy.GetXMLName() in source_names
            names = _FIRST_HANDLES if has_handles else copied_settings(proxy)

            def should_trace(accessor):
                prop = accessor.get_object()
                is_set = prop.GetXMLName() in names and (has_handles or not prop.IsValueDefault())
                return is_set or usual(accessor)

            filter.should_trace_in_create = should_trace
            return super().trace_ctor(ctor, filter, *arguments, **keywords)

    smtrace.RealProxyAccessor.register_create_callback(Accessor)
