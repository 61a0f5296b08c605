/* The standard wants every function exported: those that the zoo does not have. Without the headers, whose prototypes differ. */
#define ABSENT(name) int fmi3##name(void) { return 3; }
ABSENT(SetDebugLogging) ABSENT(InstantiateModelExchange) ABSENT(InstantiateScheduledExecution) ABSENT(Reset)
ABSENT(GetUInt8) ABSENT(GetInt16) ABSENT(GetUInt16) ABSENT(GetUInt32) ABSENT(GetInt64) ABSENT(GetClock)
ABSENT(SetUInt8) ABSENT(SetInt16) ABSENT(SetUInt16) ABSENT(SetUInt32) ABSENT(SetInt64) ABSENT(SetClock)
ABSENT(GetNumberOfVariableDependencies) ABSENT(GetVariableDependencies) ABSENT(SerializedFMUStateSize)
ABSENT(SerializeFMUState) ABSENT(DeserializeFMUState) ABSENT(GetDirectionalDerivative) ABSENT(GetAdjointDerivative)
ABSENT(EnterConfigurationMode) ABSENT(ExitConfigurationMode) ABSENT(GetIntervalDecimal) ABSENT(GetIntervalFraction)
ABSENT(GetShiftDecimal) ABSENT(GetShiftFraction) ABSENT(SetIntervalDecimal) ABSENT(SetIntervalFraction)
ABSENT(SetShiftDecimal) ABSENT(SetShiftFraction) ABSENT(EvaluateDiscreteStates) ABSENT(EnterContinuousTimeMode)
ABSENT(CompletedIntegratorStep) ABSENT(SetTime) ABSENT(SetContinuousStates) ABSENT(GetContinuousStateDerivatives)
ABSENT(GetEventIndicators) ABSENT(GetContinuousStates) ABSENT(GetNominalsOfContinuousStates)
ABSENT(GetNumberOfEventIndicators) ABSENT(GetNumberOfContinuousStates) ABSENT(ActivateModelPartition)
