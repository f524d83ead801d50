"""Bitstreams for boards, and SoCs around exported engines."""
