"""The filters in ParaView: proxies, panels, widgets and views."""
