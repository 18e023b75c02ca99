"""Anchors of the site as they are in the pages' links: python-markdown's own join hyphens and number headings differently."""

import re


def slug(text, separator):
    return re.sub(r"[^\w\- ]", "", text).lower().replace(" ", separator)


def on_config(config):
    config["mdx_configs"]["toc"] = dict(config["mdx_configs"].get("toc") or {}, slugify=slug)
    return config
