"""Physics of suspended and towed bodies at sea, as pure functions over named values.

Every model module follows the protocol of ``docs/architecture.md``; nothing here knows FMI, files or plots.
"""
