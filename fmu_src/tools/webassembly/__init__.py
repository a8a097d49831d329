"""The WebAssembly component in an FMU of FMI 3.0, from the compiled core and without other tools.

The layered standard org.modelica.fmi-ls-wasm, a working draft of the Modelica Association, names its place
and its functions. interface: the functions and types of the draft. encoding: numbers, names and sections of
WebAssembly's binary format. core: small core modules. types: types of the component model. component: the
whole.
"""
