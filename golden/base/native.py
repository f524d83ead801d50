"""What compiled functions do with memory and functions of C libraries, whose addresses are numbers."""

from llvmlite import ir
from numba import carray
from numba.core import types
from numba.extending import intrinsic

__all__ = ["array", "call", "pointer", "prefetch"]

array = carray
"""The array of a shape at a pointer."""

_BYTES = ir.IntType(8).as_pointer()


@intrinsic
def pointer(typing, address, kind):
    """The pointer at an address to values of a type of numpy, as in ``pointer(address, np.float64)[index]``."""
    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))
    return types.CPointer(kind.dtype)(types.uintp, kind), generate


@intrinsic
def call(typing, function, addresses):
    """Call the function at an address with a tuple of addresses; what it returns, if anything, is dropped."""
    count = len(addresses)

    def generate(context, builder, signature, arguments):
        given = [builder.extract_value(arguments[1], number) for number in range(count)]
        kind = ir.FunctionType(ir.VoidType(), [one.type for one in given])
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), given)
        return context.get_dummy_value()
    return types.none(types.uintp, types.UniTuple(types.uintp, count)), generate


@intrinsic
def prefetch(typing, address):
    """Have the processor read the line of the cache at an address, while it goes on."""
    def generate(context, builder, signature, arguments):
        whole = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [_BYTES, whole, whole, whole])
        function = builder.module.declare_intrinsic("llvm.prefetch", [_BYTES], kind)
        builder.call(function, [builder.inttoptr(arguments[0], _BYTES), whole(0), whole(3), whole(1)])
        return context.get_dummy_value()
    return types.none(types.uintp), generate
