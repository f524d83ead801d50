"""Parameters of one cluster that fits an ECP5-85."""

__all__ = ["NARROW"]

# Narrow numbers, one traversal pipeline, and direct placement, the policy with the smallest caches.
NARROW = {
    "numbers.scene_bits": 20, "numbers.vector_fraction": 18, "numbers.mantissa_bits": 20, "icu.product_registers": 1,
    "icu.angle_bits": 20, "icu.cordic_stages": 14, "icu.slots": 16, "icu.generation_bits": 2,
    "noc.columns": 1, "noc.rows": 1, "ctu.pipelines": 1, "memsys.cache_policy": "direct"}
