"""Procedural scenes of Regulus; one module per scene, each with build() -> {file stem: Gltf}."""
